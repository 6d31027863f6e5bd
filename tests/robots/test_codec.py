"""The K-Team protocol: every command there and back, and nothing but its own error on any bytes."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.command_table import COMMANDS, RESTART, Range, Version
from khepera_forage.robots.serial.protocol import (
    BANNER,
    MAX_LINE,
    ArgumentError,
    BannerLine,
    CodecError,
    Lines,
    Refusal,
    Reply,
    Request,
    UnknownCommandError,
    decode_reply,
    decode_request,
    encode_reply,
    encode_request,
)

SHEET = [
    (Request("A", (3800, 800, 100)), b"A,3800,800,100\n", Reply("A"), b"a\r\n"),
    (Request("B"), b"B\n", Reply("B", ("5.02", "5.01")), b"b,5.02,5.01\r\n"),
    (Request("C", (-1000, 1000)), b"C,-1000,1000\n", Reply("C"), b"c\r\n"),
    (Request("D", (5, -5)), b"D,5,-5\n", Reply("D"), b"d\r\n"),
    (Request("E"), b"E\n", Reply("E", (5, -4)), b"e,5,-4\r\n"),
    (Request("F", (3000, 20, 4000)), b"F,3000,20,4000\n", Reply("F"), b"f\r\n"),
    (Request("G", (0, -2147483648)), b"G,0,-2147483648\n", Reply("G"), b"g\r\n"),
    (Request("H"), b"H\n", Reply("H", (2147483647, -1)), b"h,2147483647,-1\r\n"),
    (Request("I", (5,)), b"I,5\n", Reply("I", (1023,)), b"i,1023\r\n"),
    (Request("J", (20, 64, 20, 64)), b"J,20,64,20,64\n", Reply("J"), b"j\r\n"),
    (Request("K"), b"K\n", Reply("K", (1, 0, 0, 0, 1, -40)), b"k,1,0,0,0,1,-40\r\n"),
    (Request("L", (1, 2)), b"L,1,2\n", Reply("L"), b"l\r\n"),
    (Request("N"), b"N\n", Reply("N", (0, 1, 2, 3, 4, 5, 6, 1023)), b"n,0,1,2,3,4,5,6,1023\r\n"),
    (Request("O"), b"O\n", Reply("O", (500,) * 8), b"o,500,500,500,500,500,500,500,500\r\n"),
    (Request("P", (-255, 255)), b"P,-255,255\n", Reply("P"), b"p\r\n"),
    (Request("R", (63,)), b"R,63\n", Reply("R", (255,)), b"r,255\r\n"),
    (Request("W", (200, 32)), b"W,200,32\n", Reply("W"), b"w\r\n"),
    (Request("T,1,B"), b"T,1,B\n", Reply("T,1,B", (2, 1)), b"t,1,b,2,1\r\n"),
    (Request("T,1,D", (1,)), b"T,1,D,1\n", Reply("T,1,D"), b"t,1,d\r\n"),
    (Request("T,1,E", (255,)), b"T,1,E,255\n", Reply("T,1,E"), b"t,1,e\r\n"),
    (Request("T,1,F"), b"T,1,F\n", Reply("T,1,F", (0,)), b"t,1,f,0\r\n"),
    (Request("T,1,G"), b"T,1,G\n", Reply("T,1,G", (180,)), b"t,1,g,180\r\n"),
    (Request("T,1,H", (0,)), b"T,1,H,0\n", Reply("T,1,H", (200,)), b"t,1,h,200\r\n"),
    (Request("T,1,J"), b"T,1,J\n", Reply("T,1,J", (0,)), b"t,1,j,0\r\n"),
]
"""Every command as drivers of the sources write and read it."""

FORBIDDEN_NUMBERS = (
    "+5", " 5", "5 ", "5_0", "--5", "-", "", "05", "-0", "00", "5.0", "1e1", "0x5", "nan", "inf", "٣", "５", "9" * 5000,
)  # fmt: skip


@pytest.mark.parametrize(("request_", "asked", "reply", "answered"), SHEET)
def test_the_bytes_of_every_command(request_: Request, asked: bytes, reply: Reply, answered: bytes) -> None:
    assert encode_request(request_) == asked
    assert encode_reply(reply) == answered
    for ending in (b"", b"\n", b"\r", b"\r\n"):
        assert decode_request(asked.rstrip() + ending) == request_
        assert decode_reply(answered.rstrip() + ending) == reply


def test_the_sheet_is_complete() -> None:
    assert {request.command for request, *_ in SHEET} | {RESTART} == set(COMMANDS)


def test_restart_is_answered_by_the_banner() -> None:
    assert encode_request(Request(RESTART)) == b"restart\n"
    assert decode_request(b"restart") == Request(RESTART)
    with pytest.raises(UnknownCommandError, match="banner"):
        encode_reply(Reply(RESTART))


@st.composite
def requests(draw: st.DrawFn) -> Request:
    name = draw(st.sampled_from(sorted(COMMANDS)))
    return Request(name, tuple(draw(st.integers(*allowed)) for allowed in COMMANDS[name].arguments))


@st.composite
def replies(draw: st.DrawFn) -> Reply:
    name = draw(st.sampled_from(sorted(set(COMMANDS) - {RESTART})))
    versions = st.from_regex(r"\A[0-9]{1,3}(\.[0-9]{1,3})?\Z")
    values: list[int | str] = [
        draw(versions) if isinstance(allowed, Version) else draw(st.integers(*allowed))
        for allowed in COMMANDS[name].results
    ]
    return Reply(name, tuple(values))


@given(requests())
def test_requests_there_and_back(request_: Request) -> None:
    line = encode_request(request_)
    assert line.endswith(b"\n")
    assert b"\r" not in line
    assert decode_request(line) == request_


@given(replies())
def test_replies_there_and_back(reply: Reply) -> None:
    line = encode_reply(reply)
    assert len(line) < 64 < MAX_LINE
    assert decode_reply(line) == reply


@given(st.text(st.characters(min_codepoint=32, max_codepoint=126)))
def test_refusals_there_and_back(text: str) -> None:
    assert decode_reply(encode_reply(Refusal(text))) == Refusal(text)


def near_protocol() -> st.SearchStrategy[bytes]:
    """Any bytes, and any that look much like the protocol."""
    parts = [
        *(name.encode() for name in COMMANDS),
        b"t",
        b"d",
        b"z",
        b",",
        b"-",
        b"0",
        b"7",
        b"255",
        b"1,",
        b"\xff",
    ]
    return st.one_of(st.binary(), st.lists(st.sampled_from(parts)).map(b"".join))


@given(near_protocol())
def test_decoding_raises_nothing_but_its_own_error_and_reads_only_what_it_writes(line: bytes) -> None:
    with contextlib.suppress(CodecError):
        assert encode_request(decode_request(line)).rstrip() == line.rstrip(b"\r\n")
    with contextlib.suppress(CodecError):
        reply = decode_reply(line)
        if not isinstance(reply, BannerLine):
            assert encode_reply(reply).rstrip(b"\r\n") == line.rstrip(b"\r\n")


@given(replies(), st.data())
def test_a_reply_with_a_byte_lost_or_changed_is_refused_or_another_well_formed_one(
    reply: Reply, data: st.DataObject
) -> None:
    line = bytearray(encode_reply(reply).rstrip())
    place = data.draw(st.integers(0, len(line) - 1))
    if data.draw(st.booleans()):
        del line[place]
    else:
        line[place] = data.draw(st.integers(0, 255))
    with contextlib.suppress(CodecError):
        decoded = decode_reply(bytes(line))
        assert not isinstance(decoded, BannerLine), "one byte does not make a word"


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_one_beyond_each_end_of_each_range_is_refused(name: str) -> None:
    command = COMMANDS[name]
    for i, allowed in enumerate(command.arguments):
        for value in (allowed.low - 1, allowed.high + 1):
            values = [r.low for r in command.arguments]
            values[i] = value
            with pytest.raises(ArgumentError, match=f"{value}.*allowed.*{allowed.low}..{allowed.high}"):
                encode_request(Request(name, tuple(values)))
            with pytest.raises(ArgumentError):
                decode_request(",".join([name, *map(str, values)]).encode())
    ranges = [r for r in command.results if isinstance(r, Range)]
    for i, allowed in enumerate(ranges):
        for value in (allowed.low - 1, allowed.high + 1):
            values = [r.low for r in ranges]
            values[i] = value
            with pytest.raises(ArgumentError):
                encode_reply(Reply(name, tuple(values)))
            with pytest.raises(ArgumentError):
                decode_reply(",".join([name.lower(), *map(str, values)]).encode())


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_one_value_too_many_or_too_few_is_refused(name: str) -> None:
    fields = ["1"] * len(COMMANDS[name].arguments)
    for wrong in ([*fields, "1"], [*fields, ""], fields[1:] if fields else ["1", "1"]):
        with pytest.raises(ArgumentError):
            decode_request(",".join([name, *wrong]).encode())
    with pytest.raises(ArgumentError, match="allowed"):
        encode_request(Request(name, (1,) * (len(fields) + 1)))
    if name != RESTART:
        with pytest.raises(ArgumentError):
            decode_reply(",".join([name.lower(), *["1"] * (len(COMMANDS[name].results) + 1)]).encode())


@pytest.mark.parametrize("number", FORBIDDEN_NUMBERS)
def test_numbers_are_plain_decimals(number: str) -> None:
    with pytest.raises(CodecError):
        decode_request(f"D,{number},5".encode())
    line = f"e,{number},5".encode()
    if number in ("nan", "inf"):
        assert decode_reply(line) == BannerLine(line.decode()), "words, no number"
        return
    with pytest.raises(CodecError):
        decode_reply(line)


@pytest.mark.parametrize("value", [True, 5.0, float("nan"), "5", None])
def test_only_whole_numbers_are_encoded(value: object) -> None:
    with pytest.raises(ArgumentError, match="whole number"):
        encode_request(Request("D", (value, 5)))  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="version"):
        encode_reply(Reply("B", (5, "5.01")))


@pytest.mark.parametrize("version", ["5.", ".5", "5.0.1", "v5", "-5", "5.0221", ""])
def test_versions_are_dotted_decimals(version: str) -> None:
    with pytest.raises(CodecError):
        decode_reply(f"b,{version},5.01".encode())
    with pytest.raises(ArgumentError):
        encode_reply(Reply("B", (version, "5.01")))


@pytest.mark.parametrize(
    "line", [b"M", b"Q", b"Z,1", b"d,5,5", b"n", b"restar", b"RESTART", b"T,1,C", b"T,1,d", b"T,1,"]
)
def test_unknown_requests(line: bytes) -> None:
    with pytest.raises(UnknownCommandError):
        decode_request(line)


@pytest.mark.parametrize("line", [b"T", b"T,", b"T,1", b"T,2,B", b"T,01,B", b"T,,B"])
def test_other_turrets_are_not_there(line: bytes) -> None:
    with pytest.raises(ArgumentError, match="turret"):
        decode_request(line)


@pytest.mark.parametrize("line", [b"", b"\n", b"D,5,5\x00", b"\xffD,5,5", b"D\n,5,5", b"D,5,5\n\n"])
def test_what_is_not_one_printable_line(line: bytes) -> None:
    for decode in (decode_request, decode_reply):
        with pytest.raises(CodecError, match="printable"):
            decode(line)


@pytest.mark.parametrize(
    "line", [b"N,1,1,1,1,1,1,1,1", b"z", b"m", b"t,1,H,5", b"", b"5.01", b",Command not found"]
)
def test_what_is_no_reply(line: bytes) -> None:
    with pytest.raises(CodecError):
        decode_reply(line)


def test_refusals_as_the_rom_writes_them() -> None:
    assert encode_reply(Refusal("Command not found")) == b"z,Command not found\r\n"
    assert decode_reply(b"z,Protocol error.\r\n") == Refusal("Protocol error.")
    with pytest.raises(ArgumentError, match="printable"):
        encode_reply(Refusal("two\nlines"))


def test_the_banner_is_recognised_also_behind_the_beginning_of_a_reply() -> None:
    for text in BANNER:
        assert decode_reply(text.encode()) == BannerLine(text)
    cut = b"n,12,3ROM of minirobot KHEPERA, Edoardo Franzi"
    assert decode_reply(cut) == BannerLine(cut.decode())


class TestLines:
    def test_endings(self) -> None:
        assert Lines().feed(b"A\nB\rC\r\nD\n\r\n\r\rE") == [b"A", b"B", b"C", b"D"]

    @given(st.lists(st.binary(min_size=1, max_size=20).map(lambda b: b.translate(None, b"\r\n"))), st.data())
    def test_the_same_lines_however_they_are_cut(self, lines: list[bytes], data: st.DataObject) -> None:
        endings = [data.draw(st.sampled_from([b"\n", b"\r", b"\r\n"])) for _ in lines]
        stream = b"".join(line + ending for line, ending in zip(lines, endings, strict=True))
        reader, read, at = Lines(), [], 0
        while at < len(stream):
            size = data.draw(st.integers(1, 7))
            read += reader.feed(stream[at : at + size])
            at += size
        assert read == [line for line in lines if line]

    def test_a_line_without_end_is_kept_short(self) -> None:
        reader = Lines()
        for _ in range(1000):
            assert reader.feed(b"x" * 100) == []
        assert reader.feed(b"\nN\n") == [b"x" * MAX_LINE, b"N"]
        assert reader.feed(b"y" * 1000 + b"\n") == [b"y" * MAX_LINE]

    def test_clear_forgets_what_has_begun(self) -> None:
        reader = Lines()
        reader.feed(b"n,1,2")
        reader.clear()
        assert reader.feed(b"d\r\n") == [b"d"]
