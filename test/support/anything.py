# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Random messages of any type, made from the type's own definition, for hypothesis."""

from math import isinf
import re
from typing import Any

from hypothesis import strategies as st

TEXTS = ('', '\0', 'Drive velocity=200 radius=straight', 'WaitTime tenths=5\nDrive velocity=1',
         'ünï¢ødé ☃', 'x' * 5000, '[' * 300, 'Safe\r\nFull', "';--")
LENGTHS = (0, 1, 15, 16, 17, 99, 100, 101, 255, 256, 1000)
SEQUENCE = re.compile(r'sequence<(.+?)(?:, (\d+))?>|(.+)\[(\d+)\]')


def integers(kind: str) -> st.SearchStrategy[int]:
    """Draw integers of a type such as uint8; limits and special values come often."""
    bits, signed = int(re.sub(r'\D', '', kind)), not kind.startswith('u')
    low = -(1 << bits - 1) if signed else 0
    high = (1 << bits - signed) - 1
    edges = {low, low + 1, 0, 1, 2, 3, 15, 16, 31, 127, high - 1, high}
    return st.sampled_from(sorted(edges)) | st.integers(low, high)


def single(kind: str) -> st.SearchStrategy[Any]:
    """Draw values of a type that is not a sequence."""
    if 'int' in kind or kind in ('octet', 'byte', 'char'):
        return integers('uint8' if kind in ('octet', 'byte', 'char') else kind)
    if kind in ('float', 'double'):
        # rosidl refuses the very largest float32.
        floats = st.floats() if kind == 'double' else st.floats(width=32).filter(
            lambda value: isinf(value) or not abs(value) > 3.402823466e38)
        return floats | st.sampled_from([0.0, 0.1875, 1.0, -1.0, 2.0, 4.0])
    if kind == 'boolean':
        return st.booleans()
    assert kind.startswith('string'), f'anything() does not know the type {kind}'
    return st.sampled_from(TEXTS) | st.text(max_size=200)


@st.composite
def anything(draw: st.DrawFn, kind: type) -> Any:
    """Draw a message with every field random; its sequences often have the same length."""
    message = kind()
    common = draw(st.sampled_from(LENGTHS))
    for name, type_ in kind.get_fields_and_field_types().items():
        found = SEQUENCE.fullmatch(type_)
        if found is not None:
            length = int(found[4] or 0) or (
                common if draw(st.booleans()) else draw(st.sampled_from(LENGTHS)))
            few = draw(st.lists(single(found[1] or found[3]), min_size=1, max_size=8))
            value = (few * length)[:length]
        elif '/' in type_:
            value = draw(anything(type(getattr(message, name))))
        else:
            value = draw(single(type_))
        setattr(message, name, value)
    return message
