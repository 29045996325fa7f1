"""Archives and XML files made to harm: each is refused with one sentence, and nothing is left behind."""

from __future__ import annotations

import stat
import zipfile
from collections.abc import Mapping
from pathlib import Path

import pytest
from block_systems import archive, block_fmu, component, description, inline, parameter_set, system
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fmus.cache import cache_folder
from orchestrator.archive import unpack
from orchestrator.errors import InputError
from orchestrator.fmi.instance import open_fmu
from orchestrator.system.reader import read_system


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Unpack into a folder of the test's own; return it."""
    monkeypatch.setenv("CURVESQUEAL_CACHE", str(tmp_path / "cache"))
    return cache_folder("unpacked")


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return block_fmu(tmp_path_factory.mktemp("block"))


def packed(path: Path, entries: Mapping[str, bytes | str]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in entries.items():
            file.writestr(name, content)
    return path


def special(path: Path, kind: int) -> Path:
    """Return an archive whose entry is of a kind of its own, with a target as content."""
    info = zipfile.ZipInfo("resources/link")
    info.create_system, info.external_attr = 3, (kind | 0o777) << 16
    with zipfile.ZipFile(path, "w") as file:
        file.writestr(info, "/etc/passwd")
    return path


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["../x"], "entry '../x' would be unpacked outside the folder; refused"),
        (["a/../../x"], "would be unpacked outside the folder; refused"),
        (["..\\x"], "would be unpacked outside the folder; refused"),
        (["/etc/x"], "would be unpacked outside the folder; refused"),
        (["C:/x"], "would be unpacked outside the folder; refused"),
        (["//host/share/x"], "would be unpacked outside the folder; refused"),
        (["."], "would be unpacked outside the folder; refused"),
        (["a", "./a"], "holds two entries './a'; refused"),
        (["a", "a/"], "holds two entries 'a/'; refused"),
        ([f"{i}" for i in range(20_001)], "holds 20001 files; at most 20000 are accepted"),
    ],
)
def test_names_that_leave_the_folder_are_refused(tmp_path: Path, cache: Path, names: list[str], message: str) -> None:
    path = packed(tmp_path / "a.ssp", dict.fromkeys(names, "x"))
    with pytest.raises(InputError) as caught:
        unpack(path, "SSP")
    assert message in str(caught.value)
    assert not list(cache.iterdir())


KINDS = {stat.S_IFLNK: "a link", stat.S_IFIFO: "no file", stat.S_IFCHR: "no file"}


@pytest.mark.parametrize(("kind", "what"), KINDS.items())
def test_links_and_devices_are_refused(tmp_path: Path, cache: Path, kind: int, what: str) -> None:
    with pytest.raises(InputError, match=f"entry 'resources/link' is {what}; refused"):
        unpack(special(tmp_path / "a.ssp", kind), "SSP")
    assert not list(cache.iterdir())


def test_zip_bombs_are_refused(tmp_path: Path, cache: Path) -> None:
    """By what the directory says, before anything is unpacked; one that understates it fails its checksum."""
    bomb = packed(tmp_path / "a.ssp", {f"{i}": bytes(30 << 20) for i in range(3)})
    with pytest.raises(InputError, match=r"unpacks to 90 MiB, \d+ times its size; at most 100 times is accepted"):
        unpack(bomb, "SSP")
    single = packed(tmp_path / "b.ssp", {"a": bytes(30 << 20)})
    size, lie = (30 << 20).to_bytes(4, "little"), (10).to_bytes(4, "little")
    single.write_bytes(single.read_bytes().replace(size, lie))
    with pytest.raises(InputError, match=r"cannot be unpacked: (Bad CRC|File size|Overlapped)"):
        unpack(single, "SSP")
    assert not list(cache.iterdir())


def test_huge_contents_are_refused(tmp_path: Path) -> None:
    """3 GiB that are not there: only the directory says so."""
    path = packed(tmp_path / "a.ssp", {"a": b"x"})
    data = bytearray(path.read_bytes())
    size = data.index(b"PK\x01\x02") + 24
    data[size : size + 4] = (3 << 30).to_bytes(4, "little")
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"unpacks to 3.0 GiB; at most 2 are accepted"):
        unpack(path, "SSP")


LEVELS = "".join(f"<!ENTITY a{i + 1} '{10 * f'&a{i};'}'>" for i in range(11))
LAUGHS = f"<!DOCTYPE x [<!ENTITY a0 'ha'>{LEVELS}]>"
OUTSIDE = '<!DOCTYPE x [<!ENTITY a11 SYSTEM "file:///etc/passwd">]>'
REFUSALS = "(has a document type declaration; refused|is not well-formed XML: (Maximum entity|Attribute references))"
REMOTE = '<!DOCTYPE x SYSTEM "http://127.0.0.1:9/x.dtd">'


@pytest.mark.parametrize("doctype", [LAUGHS, OUTSIDE, REMOTE], ids=["expansion", "external entity", "external DTD"])
def test_entities_are_refused_in_every_file(tmp_path: Path, fmu: Path, doctype: str) -> None:
    ssd = description(system(component("m", '<ssd:ParameterBinding source="resources/v.ssv"/>')))
    ssv = '<?xml version="1.0"?>' + parameter_set({"s": "&a11;" if "a11" in doctype else "x"})
    hostile = {
        "SystemStructure.ssd": (ssd.replace("?>", f"?>{doctype}", 1), ssv),
        "resources/v.ssv": (ssd, ssv.replace("?>", f"?>{doctype}", 1)),
    }
    for name, (first, second) in hostile.items():
        path = archive(tmp_path / "a.ssp", fmu, first, {"resources/v.ssv": second})
        with pytest.raises(InputError, match=f"{name} {REFUSALS}"):
            read_system(path)
    with zipfile.ZipFile(fmu) as file:
        entries = {name: file.read(name) for name in file.namelist()}
    text = entries["modelDescription.xml"].decode()
    entries["modelDescription.xml"] = text.replace("?>", f"?>{doctype}", 1).encode()
    with pytest.raises(InputError, match=r"modelDescription.xml has a document type declaration; refused"):
        open_fmu(packed(tmp_path / "a.fmu", entries))


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("../outside.fmu", "lies outside the system's folder; refused"),
        ("%2e%2e/outside.fmu", "lies outside the system's folder; refused"),
        ("resources/%2e%2e/%2E%2E/outside.fmu", "lies outside the system's folder; refused"),
        ("/etc/passwd", "lies outside the system's folder; refused"),
        ("file:///etc/passwd", "is not relative"),
        ("//host/share.fmu", "is not relative"),
        ("resources/%00.fmu", "the source is no file name"),
        (5000 * "a", "the source is no file name"),
    ],
)
def test_sources_do_not_leave_the_system(tmp_path: Path, fmu: Path, source: str, message: str) -> None:
    values = f'<ssd:ParameterBinding source="{source}"/>'
    for text in (component("m", source=source), component("m", values)):
        with pytest.raises(InputError, match=message):
            read_system(archive(tmp_path / "a.ssp", fmu, description(system(text))))


@pytest.mark.parametrize("name", ["../../x", "/etc/x", "..\\x"])
def test_names_of_results_do_not_leave_their_folder(tmp_path: Path, fmu: Path, name: str) -> None:
    with pytest.raises(InputError, match="results could not be called so; refused"):
        read_system(archive(tmp_path / "a.ssp", fmu, description(system(component("m")), name)))


def test_links_beside_an_ssd_do_not_leave_its_folder(tmp_path: Path) -> None:
    folder = tmp_path / "system"
    folder.mkdir()
    (tmp_path / "outside.fmu").write_text("secret")
    (folder / "inside.fmu").symlink_to(tmp_path / "outside.fmu")
    (folder / "a.ssd").write_text(description(system(component("m", source="inside.fmu"))))
    with pytest.raises(InputError, match="lies outside the system's folder; refused"):
        read_system(folder / "a.ssd")


def test_systems_that_contain_themselves_end(tmp_path: Path, fmu: Path) -> None:
    """A description that refers to itself, and one whose parts refer to the next twice, a million in all."""

    def reference(name: str, source: str) -> str:
        return f'<ssd:Component name="{name}" source="{source}" type="application/x-ssp-definition"/>'

    itself = description(system(reference("m", "SystemStructure.ssd")))
    with pytest.raises(InputError, match="has 51 systems around it; at most 50 are read"):
        read_system(archive(tmp_path / "a.ssp", fmu, itself))
    files = {
        f"{i}.ssd": description(system(reference("a", f"{i + 1}.ssd") + reference("b", f"{i + 1}.ssd")))
        for i in range(20)
    }
    files["20.ssd"] = description(system(""))
    top = description(system(reference("m", "0.ssd")))
    with pytest.raises(InputError, match="refers to other files more than 1000 times; refused"):
        read_system(archive(tmp_path / "b.ssp", fmu, top, files))


def test_deeply_nested_elements_end(tmp_path: Path, fmu: Path) -> None:
    text = ""
    for _ in range(3000):
        text = (
            f'<ssd:System name="s"><ssd:Elements>{text}</ssd:Elements></ssd:System>' if text else system("", name="s")
        )
    with pytest.raises(InputError, match="is not well-formed XML: Excessive depth"):
        read_system(archive(tmp_path / "a.ssp", fmu, description(text)))


def refusal(path: Path) -> str:
    """Return why a system is refused, nothing if it is read; any other exception ends the test."""
    try:
        read_system(path)
    except InputError as error:
        return str(error)
    return ""


SSD = description(system(component("m", inline({"b": 1.0})) + component("n"), bindings=inline({"n.b": 2.0})))


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.integers(0, 10_000), st.integers(0, 255)), min_size=1, max_size=12))
def test_damaged_archives_end_in_a_sentence(tmp_path: Path, changes: list[tuple[int, int]]) -> None:
    """Bytes changed anywhere: the system is read as it was, or refused; no other exception."""
    path = packed(tmp_path / "a.ssp", {"SystemStructure.ssd": SSD, "resources/v.ssv": "x"})
    data = bytearray(path.read_bytes())
    for place, value in changes:
        data[place % len(data)] = value
    path.write_bytes(data)
    assert "\n" not in refusal(path)


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, len(SSD) - 1), st.integers(0, 40), st.text(max_size=6))
def test_damaged_descriptions_end_in_a_sentence(tmp_path: Path, place: int, length: int, text: str) -> None:
    """A piece of the SSD replaced by anything: a system or a refusal."""
    path = tmp_path / "a.ssd"
    path.write_bytes((SSD[:place] + text + SSD[place + length :]).encode("utf-8", "surrogatepass"))
    said = refusal(path)
    assert not said or str(path) in said
