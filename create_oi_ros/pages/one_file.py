# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Puts ES modules into one script, for a page that is one file. Pure."""

from __future__ import annotations

from collections.abc import Mapping
import re

IMPORT = re.compile(r"^import (\{[^}]*\}) from '\./([\w.]+)';\n", re.MULTILINE)
EXPORT = re.compile(r'^export ((?:async )?(?:function|class|const) (\w+))', re.MULTILINE)
"""The only forms that our modules use: named imports, and exports where a name is declared."""


def variable(name: str) -> str:
    """Return the name of the variable that holds what a module exports."""
    return re.sub(r'\W', '_', name)


def with_constants(text: str) -> str:
    """Return a module whose imports are constants, from the variables of the other modules."""
    return IMPORT.sub(lambda found: f'const {found[1]} = {variable(found[2])};\n', text)


def as_function(name: str, text: str) -> str:
    """Return a module as a function that is called once, and returns what the module exports."""
    exported = ', '.join(found[2] for found in EXPORT.finditer(text))
    body = EXPORT.sub(r'\1', with_constants(text))
    return f'const {variable(name)} = (() => {{\n{body}\nreturn {{ {exported} }};\n}})();\n'


def one_script(modules: Mapping[str, str], entry: str) -> str:
    """Return a script that runs the module `entry`; each module stands before those using it."""
    ordered: list[str] = []

    def add(name: str) -> None:
        for found in IMPORT.finditer(modules[name]):
            if found[2] not in ordered:
                add(found[2])
        ordered.append(name)
    add(entry)
    *others, main = ordered
    return ''.join([*(as_function(name, modules[name]) for name in others),
                    with_constants(modules[main])])
