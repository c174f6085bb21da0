"""The report in a browser: silent, without a network, on a desk, on a phone, in the dark, on paper."""

from __future__ import annotations

import pytest

WIDTHS = (360, 768, 1280)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", WIDTHS)
def test_it_opens_without_a_word_or_a_request_and_fits(chromium, page_file, width, dark):
    chromium.open(page_file, width, dark=dark)
    chromium.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true })")
    assert chromium.complaints() == []
    assert chromium.requests() == [page_file.as_uri()]
    assert chromium.evaluate("document.documentElement.scrollWidth") <= width
    escaped = """[...document.querySelectorAll('body *')].filter(each => {
        if (each.closest('.scroll, svg, .unseen')) return false;
        const box = each.getBoundingClientRect();
        return box.width && (box.right > innerWidth + 0.5 || box.left < -0.5);
    }).map(each => each.outerHTML.slice(0, 80))"""
    assert chromium.evaluate(escaped) == []


def test_every_figure_is_drawn(chromium, page_file, page):
    chromium.open(page_file, 1280)
    chromium.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true })")
    sizes = chromium.evaluate(
        "[...document.querySelectorAll('figure svg')].map(each => {"
        "const box = each.getBoundingClientRect(); return [box.width, box.height, "
        "each.querySelectorAll('path, use, image').length, each.querySelectorAll('text').length]})"
    )
    assert len(sizes) == page.count("<svg")
    for width, height, shapes, words in sizes:
        assert width > 300 and height > 150 and shapes > 10 and words > 8


def test_figures_of_a_phone_can_be_read(chromium, page_file):
    chromium.open(page_file, 360)
    smallest = chromium.evaluate(
        "Math.min(...[...document.querySelectorAll('#traces > .pictures svg')].flatMap(figure => {"
        "const scale = figure.getBoundingClientRect().width / figure.viewBox.baseVal.width;"
        "return [...figure.querySelectorAll('text')]"
        ".map(each => parseFloat(getComputedStyle(each).fontSize) * scale)}))"
    )
    assert smallest > 8.0


def luminance(colour: str) -> float:
    red, green, blue = (float(part) / 255 for part in colour.strip("rgba()").split(",")[:3])
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_words_and_figures_stand_out_from_the_paper(chromium, page_file, dark):
    chromium.open(page_file, 1280, dark=dark)
    look = "getComputedStyle(document.querySelector('{}')).{}"
    paper = luminance(chromium.evaluate(look.format("body", "backgroundColor")))
    assert (paper < 0.2) is dark
    for place, property_ in (("body", "color"), ("figure svg text", "fill"), (".fine", "color")):
        ink = luminance(chromium.evaluate(look.format(place, property_)))
        assert abs(ink - paper) > 0.45, (place, ink, paper)


def test_it_prints_with_everything_unfolded_and_light(chromium, page_file):
    chromium.open(page_file, 1280, dark=True)
    assert chromium.pdf().startswith(b"%PDF")
    dark = {"name": "prefers-color-scheme", "value": "dark"}
    chromium.call("Emulation.setEmulatedMedia", media="print", features=[dark])
    paper = chromium.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--paper')")
    assert paper.strip() == "#ffffff"
    unseen = "[...document.querySelectorAll('figure, table')].filter(each => !each.checkVisibility()).length"
    assert chromium.evaluate(unseen) == 0
    chromium.call("Emulation.setEmulatedMedia", media="screen", features=[])
    assert chromium.evaluate(unseen) > 0
