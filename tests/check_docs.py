#!/usr/bin/env python3
"""Checks the Markdown files of a repository: check_docs.py ROOT

- A line has at most 100 characters. Rows of tables are exempt, since Markdown cannot break them.
- A relative link leads to a file of the repository, and its anchor to a heading there.
Prints each violation as FILE:LINE: TEXT and exits with 1 if there is one.
"""
import functools
import pathlib
import re
import subprocess
import sys

MAX_CHARACTERS = 100
LINK = re.compile(r"\]\(([^)\s]+)\)")
CODE_SPAN = re.compile(r"`[^`]*`")
SCHEME = re.compile(r"[a-z]+:")

def anchor_of(heading):
    """Anchor of a heading as GitHub makes it."""
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", "-")


def lines_outside_code(text):
    """Numbered lines outside fenced code."""
    in_code = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            in_code = not in_code
        elif not in_code:
            yield number, line


@functools.cache
def anchors(path):
    """Anchors of a file's headings; a repeated heading gets a number."""
    found = set()
    for _, line in lines_outside_code(path.read_text()):
        if match := re.match(r"#+ +(.*)", line):
            anchor, count = anchor_of(match[1]), 1
            while anchor in found:
                anchor, count = f"{anchor_of(match[1])}-{count}", count + 1
            found.add(anchor)
    return found


def problem_of(path, target):
    """What is wrong with a relative link of a file; None if it resolves."""
    name, _, anchor = target.partition("#")
    file = path.parent / name if name else path
    if not file.exists():
        return f"the link to {target} leads to no file"
    if anchor and (file.suffix != ".md" or anchor not in anchors(file)):
        return f"the link to {target} leads to no heading"
    return None


def violations(path):
    text = path.read_text()
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > MAX_CHARACTERS and not line.startswith("|"):
            yield number, f"{len(line)} characters, of at most {MAX_CHARACTERS}"
    for number, line in lines_outside_code(text):
        for target in LINK.findall(CODE_SPAN.sub("", line)):
            if not SCHEME.match(target) and (problem := problem_of(path, target)):
                yield number, problem


def documents(root):
    """Returns the documents that git knows; without git, as in a copy of the sources, all outside build folders."""
    try:
        listed = subprocess.check_output(["git", "-C", root, "ls-files", "-coz", "--exclude-standard", "*.md"], text=True)
        return sorted(root / name for name in listed.split("\0")[:-1] if (root / name).exists())
    except (FileNotFoundError, subprocess.CalledProcessError):
        ignored = {"build", "node_modules"}
        return sorted(path for path in root.rglob("*.md") if not ignored & set(path.relative_to(root).parts))


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    files = documents(root)
    found = [f"{path.relative_to(root)}:{number}: {text}" for path in files for number, text in violations(path)]
    print("\n".join(found) or f"{len(files)} documents are in order")
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main())
