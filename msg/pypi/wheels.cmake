# Included after project() (CMAKE_PROJECT_INCLUDE) where ROS comes from PyPI wheels; a Jazzy workspace never sees it.
#
# The imported targets of the wheels still name the include folders of the machine that built the wheels
# (/opt/python/...), and CMake refuses targets whose include folders do not exist. Once all packages are found,
# drop the folders that are not here.

function(drop_missing_include_folders)
  get_directory_property(targets IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(folders "${target}" INTERFACE_INCLUDE_DIRECTORIES)
    if(NOT folders)
      continue()
    endif()
    set(kept "")
    foreach(folder IN LISTS folders)
      if(folder MATCHES "^/opt/python/" AND NOT EXISTS "${folder}")
        continue()
      endif()
      list(APPEND kept "${folder}")
    endforeach()
    set_target_properties("${target}" PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${kept}")
  endforeach()
endfunction()

cmake_language(DEFER CALL drop_missing_include_folders)
