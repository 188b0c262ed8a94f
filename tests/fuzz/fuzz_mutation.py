"""Small changes to files, as damage and malice make them."""

import random

SIZE_MAX = 1 << 20  # [bytes] of a mutated file
WORDS = [
    *(
        b"[",
        b"{",
        b'"',
        b"\\",
        b"&a ",
        b"*a",
        b"<<: ",
        b"!!int ''",
        b"!!binary x",
        b"? ",
        b"- ",
        b"---\n",
        b"%YAML",
        b"~",
    ),
    *(b"NaN", b"-1", b"1e999", b"9" * 400, b"0x", b"\xff\xfe", b"\x00", b"\xed\xa0\x80", b"\\ud800", b"null", b"\r\n"),
    *(b"<!DOCTYPE a>", b"&lt;", b"&#0;", b"]]>", b"<a ", b"/>", b"\xef\xbb\xbf", b"\xff" * 8, b"\x7f" + b"\xff" * 7),
]


def mutated(seeds: list[bytes], random_: random.Random) -> bytes:
    """One of the seeds with a few changes of the usual kinds."""
    data = bytearray(random_.choice(seeds))
    for _ in range(random_.choice((1, 1, 2, 4, 16))):
        place = random_.randrange(len(data) + 1)
        end = min(len(data), place + random_.choice((1, 2, 4, 8, 64, 512)))
        match random_.randrange(8):
            case 0:
                data[place:end] = random_.randbytes(end - place)
            case 1:
                del data[place:end]
            case 2:
                data[place:place] = random_.choice(WORDS) * random_.choice((1, 1, 1, 3, 100))
            case 3:
                data[place:place] = data[place:end] * random_.choice((1, 2, 200))
            case 4 if place < len(data):
                data[place] ^= 1 << random_.randrange(8)
            case 5:
                data[place:end] = random_.choice((b"\0", b"\xff", b"9", b" ")) * (end - place)
            case 6:
                other = random_.choice(seeds)
                data[place:end] = other[random_.randrange(len(other) + 1) :][:4096]
            case _:
                del data[place:]
    return bytes(data[:SIZE_MAX])
