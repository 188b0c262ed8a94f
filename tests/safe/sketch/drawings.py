"""Sketches in the manner of crash reports, drawn for the tests."""

import io
import math

from PIL import Image, ImageDraw, ImageFont

from roadmend.language.chat import Image as Sketch

RED, BLUE, GREEN = (220, 20, 20), (30, 80, 200), (20, 190, 40)


class Drawing:
    """A sheet of paper; angles are in degrees, counter-clockwise from the right."""

    def __init__(self, width=1000, height=700):
        self.image = Image.new("RGB", (width, height), "white")
        self.pen = ImageDraw.Draw(self.image)

    def text(self, x, y, text, size=24):
        self.pen.text((x, y), text, "black", ImageFont.load_default(size))
        return self

    def line(self, *points, width=2):
        self.pen.line(points, "black", width)
        return self

    def arrow(self, begin, end, width=3, head=14):
        angle = math.atan2(end[1] - begin[1], end[0] - begin[0])
        neck = end[0] - head * math.cos(angle), end[1] - head * math.sin(angle)
        side = head * 0.45 * math.sin(angle), -head * 0.45 * math.cos(angle)
        self.pen.line((*begin, *neck), "black", width)
        self.pen.polygon([end, (neck[0] + side[0], neck[1] + side[1]), (neck[0] - side[0], neck[1] - side[1])], "black")
        return self

    def vehicle(self, x, y, heading, colour, label="", *, triangle=True, length=110, width=44):
        """A filled rectangle with its label and, at the front, a white triangle."""
        scale = 4
        tile = Image.new("RGBA", (scale * length, scale * width), (*colour, 255))
        pen = ImageDraw.Draw(tile)
        pen.rectangle((0, 0, tile.width - 1, tile.height - 1), outline="black", width=scale * 2)
        if triangle:
            base, tip, middle = 0.76 * tile.width, 0.9 * tile.width, tile.height / 2
            pen.polygon([(base, middle - 30), (base, middle + 30), (tip, middle)], "white", "black")
        if label:
            pen.text((tile.width * 0.4, tile.height / 2), label, "white", ImageFont.load_default(scale * 22), "mm")
        tile = tile.resize((length, width), Image.Resampling.LANCZOS)
        turned = tile.rotate(heading, Image.Resampling.BICUBIC, expand=True)
        self.image.paste(turned, (round(x - turned.width / 2), round(y - turned.height / 2)), turned)
        return self

    def compass(self, x, y, radius, heading, *, dark="black", light=(128, 128, 128)):
        """A disc with a block arrow in it that points north."""
        self.pen.ellipse((x - radius, y - radius, x + radius, y + radius), light)
        way = math.radians(heading)
        shape = [(1, 0), (0, 0.97), (0, 0.28), (-0.95, 0.28), (-0.95, -0.28), (0, -0.28), (0, -0.97)]
        self.pen.polygon(
            [
                (
                    x + radius * (along * math.cos(way) - aside * math.sin(way)),
                    y - radius * (along * math.sin(way) + aside * math.cos(way)),
                )
                for along, aside in shape
            ],
            dark,
        )
        return self

    def sketch(self, kind="png"):
        data = io.BytesIO()
        self.image.save(data, kind, **({"quality": 85} if kind == "jpeg" else {}))
        return Sketch(data.getvalue(), f"image/{kind}")
