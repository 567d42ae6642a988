# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes as text."""

import json
import re


def key(of):
    """A key, in quotes where it needs them."""
    return of if re.fullmatch(r"[A-Za-z0-9_-]+", of) else json.dumps(of, ensure_ascii=False)


def value(of):
    """A value on one line."""
    if isinstance(of, bool):
        return "true" if of else "false"
    if isinstance(of, str):
        return json.dumps(of, ensure_ascii=False)
    if isinstance(of, (int, float)):
        return repr(float(of)) if isinstance(of, float) else str(of)
    if isinstance(of, dict):
        return "{ " + ", ".join(f"{key(name)} = {value(each)}" for name, each in of.items()) + " }"
    return "[" + ", ".join(map(value, of)) + "]"


def text(table):
    """The text of a scene: plain values first, then tables, then lists of tables."""
    lines = [f"{key(name)} = {value(of)}" for name, of in table.items() if not is_table(of) and not is_tables(of)]
    for head, of in table.items():
        for each in [of] if is_table(of) else of if is_tables(of) else []:
            lines += ["", f"[{key(head)}]" if is_table(of) else f"[[{key(head)}]]"]
            lines += [f"{key(name)} = {value(inner)}" for name, inner in each.items()]
    return "\n".join(lines) + "\n"


def is_table(of):
    return isinstance(of, dict)


def is_tables(of):
    return isinstance(of, list) and bool(of) and all(map(is_table, of))
