"""The order of the tests: long ones first, so that the last worker at work has only short ones left."""


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)
