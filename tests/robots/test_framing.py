"""Framing: bytes in any chunks split into lines."""

from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.framing import MAX_LINE, LineSplitter


def test_all_line_endings_are_split() -> None:
    assert LineSplitter().feed(b"A\nB\rC\r\nD\n\r\n\r\rE") == [b"A", b"B", b"C", b"D"]


@given(st.lists(st.binary(min_size=1, max_size=20).map(lambda b: b.translate(None, b"\r\n"))), st.data())
def test_lines_do_not_depend_on_the_chunks(lines: list[bytes], data: st.DataObject) -> None:
    endings = [data.draw(st.sampled_from([b"\n", b"\r", b"\r\n"])) for _ in lines]
    stream = b"".join(line + ending for line, ending in zip(lines, endings, strict=True))
    reader, read, at = LineSplitter(), [], 0
    while at < len(stream):
        size = data.draw(st.integers(1, 7))
        read += reader.feed(stream[at : at + size])
        at += size
    assert read == [line for line in lines if line]


def test_line_without_end_is_truncated() -> None:
    reader = LineSplitter()
    for _ in range(1000):
        assert reader.feed(b"x" * 100) == []
    assert reader.feed(b"\nN\n") == [b"x" * MAX_LINE, b"N"]
    assert reader.feed(b"y" * 1000 + b"\n") == [b"y" * MAX_LINE]
