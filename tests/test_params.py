"""Parameters: flags beat the file, and what is not understood is refused with a hint."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import pytest

from fpnav.errors import UsageError
from fpnav.params import (
    NO_TABLES,
    NotNegative,
    Params,
    Positive,
    Share,
    as_dict,
    choose_preset,
    read_tables,
    resolve,
)


class Toy(Params, frozen=True):
    theta: float | Literal["auto"] = 0.5
    nodes: int = 0
    bright: bool = False
    share: Share = 0.5
    least: NotNegative = 0.0
    step: Positive = 1.0


KNOWN = ("toy", "filter")


def toy(*settings: str, file: Path | None = None) -> Toy:
    return resolve("toy", Toy(), read_tables(file, settings, KNOWN))


@pytest.fixture
def toml(tmp_path: Path) -> Path:
    file = tmp_path / "params.toml"
    file.write_text("[toy]\ntheta = 0.25\nnodes = 3\n")
    return file


def test_without_file_and_flags_the_default_stands() -> None:
    assert resolve("toy", Toy(nodes=7), NO_TABLES) == Toy(nodes=7)


def test_the_file_overrides_the_default_and_flags_beat_the_file(toml: Path) -> None:
    assert toy(file=toml) == Toy(theta=0.25, nodes=3)
    assert toy("toy.nodes=9", file=toml) == Toy(theta=0.25, nodes=9)


def test_a_later_flag_beats_an_earlier_one() -> None:
    assert toy("toy.nodes=1", "toy.nodes=2").nodes == 2


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("toy.theta=0.25", Toy(theta=0.25)),
        ("toy.theta=1", Toy(theta=1.0)),
        ("toy.theta=auto", Toy(theta="auto")),
        ('toy.theta="auto"', Toy(theta="auto")),
        (" toy.nodes = 4 ", Toy(nodes=4)),
        ("toy.bright=true", Toy(bright=True)),
    ],
)
def test_settings_are_toml_values_or_bare_words(setting: str, expected: Toy) -> None:
    assert toy(setting) == expected


@pytest.mark.parametrize("setting", ["toy.theta", "theta=1", ".theta=1", "toy.=1", "=", ""])
def test_a_setting_of_another_form_is_refused_with_the_form(setting: str) -> None:
    with pytest.raises(UsageError, match=r"expected block\.key=value"):
        toy(setting)


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("toy.thets=1", r"no parameter toy\.thets; did you mean 'theta'\?"),
        ("toy.zzz=1", r"no parameter toy\.zzz; known: bright, least, nodes, share, step, theta"),
        ("tpy.theta=1", r"no parameter block 'tpy'; did you mean 'toy'\?"),
        ("toy.nodes=2.5", r"parameter block 'toy': Expected `int`, got `float`"),
        ("toy.nodes=many", r"Expected `int`, got `str` - at `\$\.nodes`"),
        ("toy.theta=otsu", r"\$\.theta"),
        ("toy.bright=1", r"Expected `bool`"),
        ("toy.share=1.5", r"<= 1.0 - at `\$\.share`"),
        ("toy.least=-1", r">= 0.0 - at `\$\.least`"),
        ("toy.step=0", r"> 0.0 - at `\$\.step`"),
        ("toy.theta=nan", r"toy\.theta: nan is not a finite number"),
        ("toy.theta=-inf", r"toy\.theta: -inf is not a finite number"),
        ("toy.theta=" + "[" * 50_000, r"\$\.theta"),
    ],
)
def test_what_is_not_understood_is_refused_with_a_hint(setting: str, said: str) -> None:
    with pytest.raises(UsageError, match=said):
        toy(setting)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("theta = 1", "'theta' stands outside a table"),
        ("[toy\n", "not a TOML parameter file"),
        ("toy = " + "[" * 50_000, "not a TOML parameter file"),
        ("[tpy]\ntheta = 1", "did you mean 'toy'"),
        ("[toy]\ntheta = nan", "not a finite number"),
    ],
)
def test_a_file_that_is_not_understood_is_refused(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(text)
    with pytest.raises(UsageError, match=said):
        toy(file=file)


def test_a_file_that_is_not_text_or_not_there_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "bad.toml"
    with pytest.raises(UsageError, match="no such parameter file"):
        toy(file=file)
    file.write_bytes(b"\xff\xfe")
    with pytest.raises(UsageError, match="not a TOML parameter file"):
        toy(file=file)


def test_a_block_goes_to_a_header_and_back() -> None:
    block = Toy(theta="auto", nodes=3)
    assert resolve("toy", Toy(), {"toy": as_dict(block)}) == block


def test_a_preset_is_chosen_by_name_or_those_there_are_named() -> None:
    presets = {"paper": Toy(nodes=1), "default": Toy()}
    assert choose_preset("toy", presets, "paper").nodes == 1
    with pytest.raises(UsageError, match="toy has no preset 'papers'; it has paper, default"):
        choose_preset("toy", presets, "papers")
