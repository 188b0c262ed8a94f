"""JSON schemas as language models' strict modes want them, and answers read by the type that the schema came from."""

from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from roadmend.language.errors import AnswerError

Answer = TypeVar("Answer")
_SHOWN = 5  # problems of one answer


def answer_schema(adapter: TypeAdapter[Any]) -> dict[str, Any]:
    """The schema of a type with every field required and none besides, as strict modes demand.

    Args:
        adapter: of a type whose fields are all to be given, null where they may be None.
    """
    schema: dict[str, Any] = _strict(adapter.json_schema())
    return schema


def _strict(node: Any) -> Any:
    if isinstance(node, list):
        return [_strict(each) for each in node]
    if not isinstance(node, dict):
        return node
    result = {name: _strict(value) for name, value in node.items() if name not in {"default", "title"}}
    if node.get("type") == "object" and isinstance(node.get("properties"), dict):
        # A field may well be called as what is dropped elsewhere.
        result["properties"] = {name: _strict(value) for name, value in node["properties"].items()}
        result |= {"required": [*node["properties"]], "additionalProperties": False}
    return result


def parse_answer(adapter: TypeAdapter[Answer], text: str) -> Answer:
    """An answer as the type that its schema came from.

    Raises:
        AnswerError: it is broken JSON, or a field is missing, unknown or has a value that it cannot have.
    """
    try:
        return adapter.validate_json(text, strict=True)
    except ValidationError as error:
        problems = [
            f"{'.'.join(str(part) for part in each['loc']) or 'the answer'}: {each['msg']}"
            for each in error.errors(include_url=False)[:_SHOWN]
        ]
        raise AnswerError("; ".join(problems)) from None
