"""The Python examples of the page on arms run as they are."""

import re
from pathlib import Path
from typing import Any

import numpy as np

PAGE = Path(__file__).parents[2] / "docs" / "arms.md"


def test_the_examples_of_the_page_on_arms_run() -> None:
    names: dict[str, Any] = {}
    examples = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    for example in examples:
        exec(compile(example, str(PAGE), "exec"), names)
    assert len(examples) == 2 and names["motion"].achieved
    assert np.array_equal(names["path"].corners[-1], names["goal"])
