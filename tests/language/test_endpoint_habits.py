"""What a complaint is taken to mean: for all requests to come, or for the pictures of one."""

import pytest

from roadmend.language.chat import ChatMessage, ChatRole, Image, Request
from roadmend.language.endpoint_habits import PICTURES, EndpointHabits

REQUEST = Request("answer", (ChatMessage(ChatRole.USER, ("Look:", Image(b"BM", "image/bmp"))),), {})


@pytest.mark.parametrize(
    "complaint",
    [
        "You uploaded an unsupported image. Please make sure your image has of one the following formats: ['png']",
        "Invalid MIME type. Only image types are supported.",
        "Invalid image: image/bmp",
        "cannot identify image file <_io.BytesIO object at 0x7f>",
        "Failed to load image or audio file",
        "The image size exceeds 20 MB",
        "413 Request Entity Too Large",
        "Payload too large",
        "At most 1 image(s) may be provided in one request.",
    ],
)
def test_of_one_picture(complaint):
    lesser = EndpointHabits().after(complaint, REQUEST, None)
    assert "image_url" not in str(lesser.body(REQUEST, None))
    assert lesser.left_out(REQUEST) == (PICTURES,)
    assert lesser.lasting == EndpointHabits()  # the next picture may be taken
    assert lesser.after(complaint, REQUEST, None) is None  # there is nothing more to leave out


@pytest.mark.parametrize(
    "complaint",
    [
        "image input is not supported - hint: you may need to provide the mmproj",
        "This model does not support vision.",
        "messages[2]: unknown variant `image_url`, expected `text` at line 1 column 20",
        "invalid type: sequence, expected a string",
        "At most 0 image(s) may be provided in one request.",
        "Model does not support images; response_format is fine",
    ],
)
def test_of_every_picture(complaint):
    lesser = EndpointHabits().after(complaint, REQUEST, None)
    assert lesser.lasting == lesser == EndpointHabits(images=False)
