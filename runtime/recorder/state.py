from typing import Any


def restore(root: Any, words: Any) -> None:
    raise NotImplementedError
    raise NotImplementedError
