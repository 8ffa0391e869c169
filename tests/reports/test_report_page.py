"""Pages: whatever stands in the values, a page shows it as text, and is one file."""

import re
from pathlib import Path

import jinja2
import pytest

from active_perceiver.reports.page import Figure, Table, write_page
from active_perceiver.reports.search_card import SearchCard

NASTY = "<script>alert('x')</script> & \"quotes\""
ESCAPED = "&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt; &amp; &#34;quotes&#34;"


def values(text: str) -> dict[str, object]:
    """Everything that the page of a search shows, all of it this text."""
    figures = [Figure.of(b"picture", ".webp", text), Figure.of(b"video", ".mp4", text)]
    table = Table([text, text], [[text, 1.5], [text, None]], text)
    return {"title": text, "lead": text, "card": SearchCard(text, text, figures, figures[:1]), "steps": table,
            "setup": Table((), [[text, text]])}  # fmt: skip


def test_values_are_text_and_never_html(tmp_path: Path) -> None:
    write_page(tmp_path / "page.html", "search_report.html.j2", **values(NASTY))
    page = (tmp_path / "page.html").read_text()
    assert "<script" not in page
    # The title twice, the lead, the card's title and verdict, two captions with an alternative text and one more
    # without, two tables with five cells and a note, and two cells.
    assert page.count(ESCAPED) == 2 + 1 + 2 + 5 + 5 + 2
    assert list(tmp_path.iterdir()) == [tmp_path / "page.html"]


def test_pictures_and_videos_are_in_the_page(tmp_path: Path) -> None:
    write_page(tmp_path / "page.html", "search_report.html.j2", **values("plain"))
    page = (tmp_path / "page.html").read_text()
    assert re.findall(r'(?:src|href)="(?!data:)', page) == []
    assert page.count("data:image/webp;base64,cGljdHVyZQ==") == page.count("<img") == 2
    assert page.count("data:video/mp4;base64,dmlkZW8=") == page.count("<video") == 1
    assert page.count("<tr>") == 1 + 2 + 1
    assert "border-collapse" in page


def test_a_value_that_is_missing_is_an_error_and_no_page(tmp_path: Path) -> None:
    lacking = values("plain")
    del lacking["setup"]
    with pytest.raises(jinja2.UndefinedError, match="setup"):
        write_page(tmp_path / "page.html", "search_report.html.j2", **lacking)
    assert list(tmp_path.iterdir()) == []


def test_what_no_page_shows_is_refused() -> None:
    with pytest.raises(ValueError, match=r"not '\.exe'"):
        Figure.of(b"", ".exe")


def test_every_template_is_used_and_all_that_are_used_are_there() -> None:
    import active_perceiver.reports as reports

    folder = Path(reports.__file__).parent
    named: set[str] = set()
    for file in [*folder.glob("*.py"), *folder.glob("templates/*.j2")]:
        named |= set(re.findall(r'"([\w.]+\.(?:j2|css))"', file.read_text()))
    assert named == {file.name for file in (folder / "templates").iterdir()}
