"""A definition as rosbag2 writes it where a type was made from an .idl file."""

_RULE = "=" * 80

HEADER_IDL = f"""{_RULE}
IDL: std_msgs/msg/Header
// generated from rosidl_adapter/resource/msg.idl.em

#include "builtin_interfaces/msg/Time.idl"

module std_msgs {{
  module msg {{
    @verbatim (language="comment", text=
      "Standard metadata." "\\n"
      "In a particular coordinate frame.")
    struct Header {{
      builtin_interfaces::msg::Time stamp;

      string frame_id;
    }};
  }};
}};

{_RULE}
IDL: builtin_interfaces/msg/Time
module builtin_interfaces {{
  module msg {{
    struct Time {{
      int32 sec;

      uint32 nanosec;
    }};
  }};
}};
"""
