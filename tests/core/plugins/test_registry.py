"""Plugins are found from metadata; one that cannot be used is one clear line and harms no other."""

from __future__ import annotations

import sys
import zlib
from collections.abc import Iterator, Mapping
from importlib.metadata import PathDistribution, distributions
from pathlib import Path

import pytest
from tests.core.plugins.packages import STAGE, install

from followspot.cli.main import main
from followspot.plugins.catalogue import StageEntry, catalogue, read_catalogue
from followspot.plugins.registry import PluginError, examined, load_stage

V1 = "[followspot.plugins.v1]\n"


def stages(site: Path) -> Mapping[str, StageEntry]:
    return read_catalogue(entry for d in distributions(path=[str(site)]) for entry in d.entry_points)


def states(site: Path) -> dict[str, str]:
    return {name: stage.state for name, stage in stages(site).items()}


def problem(site: Path, name: str) -> str:
    text = stages(site)[name].problem
    assert "\n" not in text
    return text


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of packages, first on the import path."""
    monkeypatch.syspath_prepend(str(tmp_path))
    catalogue.cache_clear()
    yield tmp_path
    catalogue.cache_clear()
    for name, module in list(sys.modules.items()):
        if str(getattr(module, "__file__", None) or "").startswith(str(tmp_path)):
            del sys.modules[name]


def test_every_stage_of_followspot_itself_is_well() -> None:
    own = [entry for entry in catalogue().values() if entry.distribution == "followspot"]
    assert len(own) > 10
    assert {entry.name: entry.problem for entry in map(examined, own) if entry.state != "ok"} == {}


def test_discovery_imports_nothing(site: Path) -> None:
    install(site, "keys", V1 + "keys.piano = keys_stage:Piano", modules={"keys_stage.py": "raise SystemExit"})
    entry = catalogue()["keys.piano"]
    assert (entry.distribution, entry.version, entry.value, entry.state) == (
        "keys",
        "1.0",
        "keys_stage:Piano",
        "ok",
    )
    assert "keys_stage" not in sys.modules


def test_a_stage_of_another_package_is_loaded_when_it_is_used(site: Path) -> None:
    install(site, "keys", V1 + "keys.piano = keys_ok:Piano", modules={"keys_ok.py": STAGE})
    assert load_stage("keys.piano").__name__ == "Piano"


def test_the_catalogue_cannot_be_changed() -> None:
    with pytest.raises(TypeError):
        catalogue()["balls.mean"] = catalogue()["balls.kalman"]  # type: ignore[index]


def test_a_name_that_two_packages_offer_is_a_duplicate_and_names_both(site: Path) -> None:
    install(site, "keys", V1 + "keys.piano = keys:Piano", modules={"keys.py": STAGE})
    install(site, "more-keys", V1 + "keys.piano = keys:Piano\nkeys.harp = keys:Piano")
    assert states(site) == {"keys.piano": "duplicate", "keys.harp": "ok"}
    assert "keys and more-keys" in problem(site, "keys.piano") or "more-keys and keys" in problem(
        site, "keys.piano"
    )


class Counted(PathDistribution):
    """Knows how often its metadata were read."""

    read = 0

    def read_text(self, filename: object) -> str | None:
        self.read += filename == "METADATA"
        return super().read_text(filename)  # type: ignore[arg-type]


def test_many_stages_of_a_package_cost_no_more_readings_of_its_metadata_than_one(site: Path) -> None:
    entries = "".join(f"keys.piano{i} = keys:Piano\n" for i in range(20))
    needs = ["numpy>=1", "pydantic>=2", "followspot>=0.1"]
    install(site, "keys", V1 + entries, requires=needs, modules={"keys.py": STAGE})
    package = Counted(next(site.glob("*.dist-info")))
    assert {stage.state for stage in read_catalogue(package.entry_points).values()} == {"ok"}
    assert 0 < package.read <= 4  # name, version, what it needs


def test_another_version_of_the_interface_is_outdated(site: Path) -> None:
    install(site, "old", "[followspot.plugins.v0]\nold.piano = old:Piano", modules={"old.py": STAGE})
    assert states(site) == {"old.piano": "outdated"}
    assert "old speaks followspot.plugins.v0, this followspot followspot.plugins.v1" in problem(
        site, "old.piano"
    )


def test_a_package_for_another_followspot_is_outdated(site: Path) -> None:
    needs = ["followspot>=99", "numpy>=1"]
    install(site, "new", V1 + "new.piano = new:Piano", requires=needs, modules={"new.py": STAGE})
    assert states(site) == {"new.piano": "outdated"}
    assert "new needs followspot >=99" in problem(site, "new.piano")


def test_a_well_version_wins_over_an_outdated_one_of_the_same_name(site: Path) -> None:
    install(site, "keys", V1 + "keys.piano = keys:Piano", modules={"keys.py": STAGE})
    install(site, "older", "[followspot.plugins.v0]\nkeys.piano = keys:Piano")
    assert states(site) == {"keys.piano": "ok"}


def test_metadata_without_its_module_is_half_installed(site: Path) -> None:
    install(site, "gone", V1 + "gone.piano = gone_package.stage:Piano")
    assert states(site) == {"gone.piano": "half-installed"}
    assert "reinstall gone" in problem(site, "gone.piano")


def test_an_entry_that_names_no_class_is_broken(site: Path) -> None:
    install(site, "odd", V1 + "odd.piano = odd\nodd.harp = ")
    assert states(site) == {"odd.piano": "broken", "odd.harp": "broken"}
    assert "where package.module:Class belongs" in problem(site, "odd.piano")


@pytest.mark.parametrize(
    ("module", "said"),
    [
        ("1 / 0", "keys fails on import: ZeroDivisionError: division by zero"),
        ("raise SystemExit('bye')", "keys fails on import: SystemExit: bye"),
        ("raise ValueError('two\\nlines')", "keys fails on import: ValueError: two lines"),
        ("def (", "keys fails on import: SyntaxError"),
        ("import no_such_package", "ModuleNotFoundError: No module named 'no_such_package'"),
        ("Piano = 3", "has no stage class Piano"),
        ("", "has no stage class Piano"),
        (STAGE.replace(" -> Source[Note]", ""), "keys is broken: Piano.process says not what it returns"),
    ],
)
def test_a_stage_that_cannot_be_imported_is_one_line_and_breaks_only_its_users(
    site: Path, module: str, said: str
) -> None:
    name = f"keys_{zlib.crc32(module.encode())}"  # imports are remembered by name
    install(site, "keys", V1 + f"keys.piano = {name}:Piano", modules={f"{name}.py": module})
    with pytest.raises(PluginError) as caught:
        load_stage("keys.piano")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert examined(catalogue()["keys.piano"]).state == "broken"
    assert load_stage("balls.mean").__name__ == "Mean"


OPTIONAL = ['numpy>=1; extra == "all"', 'Grand-Piano>=2 ; extra == "all"', 'grand-piano>=2; extra == "piano"']


def test_a_stage_whose_optional_package_is_missing_is_not_installed_and_says_how_to(site: Path) -> None:
    module = "import grand_piano.keys"
    install(
        site, "keys", V1 + "keys.piano = keys_opt:Piano", requires=OPTIONAL, modules={"keys_opt.py": module}
    )
    entry = examined(catalogue()["keys.piano"])
    assert (entry.state, entry.problem) == ("not installed", "pip install 'keys[piano]'")
    with pytest.raises(PluginError) as caught:
        load_stage("keys.piano")
    assert str(caught.value) == "keys.piano: not installed; pip install 'keys[piano]'"


@pytest.mark.parametrize("needs", [["grand-piano>=2"], ['harp; extra == "piano"'], ["?"], []])
def test_a_missing_package_that_no_extra_brings_breaks_the_stage(site: Path, needs: list[str]) -> None:
    name = f"keys_{zlib.crc32(repr(needs).encode())}"
    files = {f"{name}.py": "import grand_piano"}
    install(site, "keys", V1 + f"keys.piano = {name}:Piano", requires=needs, modules=files)
    assert examined(catalogue()["keys.piano"]).state == "broken"


def test_an_unknown_stage_is_answered_with_the_nearest_name() -> None:
    with pytest.raises(PluginError) as caught:
        load_stage("balls.kallman")
    assert caught.value.problem == 'no stage "balls.kallman" is installed'
    assert str(caught.value.remedy).startswith('did you mean "balls.kalman"?')


def test_many_choices_stand_below_the_table_of_parameters(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plugins", "vision.aruco"]) == 0
    table, _, below = capsys.readouterr().out.partition("\n\n  dictionary: ")
    assert max(map(len, table.splitlines())) < 110
    assert "22 choices" in table
    assert "; one of DICT_4X4_50, DICT_4X4_100, " in below.splitlines()[0]
