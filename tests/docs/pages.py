"""What a page of the documentation promises: its fenced blocks, taken one after the other as a reader would.

```python               executed; the blocks of a page share their names
```python title="x.py"  written to that file and run as a script
```toml title="x.toml"  written to that file; without a title it is a part of a file and has to be TOML
```console              commands, one a line, `edmd` or `python`, that end with exit status 0; `> file` and `# remarks` as in a shell
```text                 something to look at
A comment in front of a block changes that, and says why:
<!-- slow: why -->       only `make validate` runs it
<!-- elsewhere: why -->  it is not run here
<!-- status 2: why -->   the exit status of its commands
<!-- before: ... -->      Python to be executed first, which a reader need not see
"""

import os
import re
import shlex
import subprocess
import sys
import tomllib
from contextlib import redirect_stdout
from pathlib import Path
from typing import NamedTuple

from edmd.cli import main

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([ROOT / "README.md", ROOT / "CHANGELOG.md", *(ROOT / "docs").rglob("*.md")])
LANGUAGES = ("python", "toml", "console", "text")
BLOCK = re.compile(r"(?:<!-- (\w[^:\n]*):\s((?:(?!-->).)*)-->\n+)?^( *)```([^\n`]*)\n(.*?)^ *```$", re.DOTALL | re.MULTILINE)
TITLE = re.compile(r'(\w*)(?: title="([\w.]+)")?')


class Block(NamedTuple):
    """A fenced block: what its comment says, its language and title, its text and the line where it begins."""

    note: str | None
    reason: str
    language: str
    title: str | None
    text: str
    line: int


def blocks(page):
    """The blocks of a page. ValueError for a language that is not one of ours."""
    text = page.read_text()
    found = []
    for match in BLOCK.finditer(text):
        note, reason, _, head, body = match.groups()
        line = text[:match.start(4)].count("\n") + 1
        named = TITLE.fullmatch(head)
        if not named or named[1] not in LANGUAGES:
            raise ValueError(f"{page.name}:{line}: a block of {head!r}; expected one of {', '.join(LANGUAGES)}")
        found.append(Block(note, reason or "", named[1], named[2], body, line))
    if (number := len(re.findall(r"^ *```", text, re.MULTILINE))) != 2 * len(found):
        raise ValueError(f"{page.name}: {number} fences make {len(found)} blocks")
    return found


def is_run(block):
    return block.language != "text" and block.note != "elsewhere"


def follow(page, slow):
    """Do what the page says, in the current folder; -> the names that its Python has made. Slow blocks are left out unless `slow`."""
    names = {"__name__": "a_page"}
    for block in blocks(page):
        if block.note == "before":
            exec(compile(block.reason, f"{page.name} before line {block.line}", "exec"), names)
        if not is_run(block) or (block.note == "slow" and not slow):
            continue
        if block.title:
            Path(block.title).write_text(block.text)
        if block.language == "toml":
            tomllib.loads(block.text)
        elif block.language == "python" and block.title:
            assert command(f"python {block.title}") == 0, f"{page.name}:{block.line}"
        elif block.language == "python":
            exec(compile("\n" * block.line + block.text, page.name, "exec"), names)
        else:
            expected = int(block.note.split()[1]) if block.note and block.note.startswith("status") else 0
            for line in filter(None, block.text.splitlines()):
                assert command(line) == expected, f"{page.name}:{block.line}: {line}"
    return names


def command(line):
    """Run one line; -> its exit status. What it says goes to the file after `>`, or nowhere."""
    words, _, output = line.partition(" > ")
    program, *arguments = shlex.split(words, comments=True)
    if program == "edmd":
        with open(output.strip() or os.devnull, "w") as told, redirect_stdout(told):
            return main(arguments)
    assert program == "python", f"{program}: expected edmd or python"
    arguments = [str(ROOT / word) if word.startswith("examples/") else word for word in arguments]
    paths = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    return subprocess.run([sys.executable, *arguments], env=os.environ | {"PYTHONPATH": paths, "MPLBACKEND": "agg"}, check=False,
                          stdout=subprocess.DEVNULL).returncode
