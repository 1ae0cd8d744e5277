"""Towns draw each Kind of random numbers, and use each random Field, in one place of the code: no two draws share an address."""

import collections
import re
import unittest
from pathlib import Path

CORE = Path(__file__).resolve().parents[2] / "src/core"
HEADERS = {"Kind": CORE / "models/models.h", "Field": CORE / "town/relief.h"}


def names_of(enum):
    body = re.search(rf"^enum class {enum} .*?\{{(.*?)\}};", HEADERS[enum].read_text(), re.S | re.M).group(1)
    return {name for name in re.findall(r"\b[A-Z]\w*", re.sub(r"//.*", "", body)) if name != "Count"}


class Purposes(unittest.TestCase):
    def test_each_is_used_in_one_place(self):
        text = "".join(file.read_text() for folder in ("models", "town") for file in sorted((CORE / folder).glob("*.cpp")))
        drawn = re.sub(r"\bmodel\(Kind::\w+", "", text)  # models that are built once are kept by their Kind, too
        for enum in HEADERS:
            uses = collections.Counter(re.findall(rf"\b{enum}::(\w+)", drawn))
            self.assertEqual([name for name in names_of(enum) if uses[name] > 1], [], enum)
            self.assertLessEqual(names_of(enum), set(re.findall(rf"\b{enum}::(\w+)", text)), "no use")


if __name__ == "__main__":
    unittest.main()
