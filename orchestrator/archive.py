"""Unpacking of FMUs and SSPs from anywhere: nothing in an archive may reach outside its folder or fill the disk."""

from __future__ import annotations

import hashlib
import shutil
import stat
import tempfile
import zipfile
import zlib
from contextlib import suppress
from pathlib import Path, PurePosixPath

from lxml import etree

from fmus.cache import cache_folder, mark_used

from .errors import Fault, InputError

LARGEST_CONTENT = 2 << 30
"""Largest total size of an unpacked archive [bytes]."""

LARGEST_COUNT = 20_000
"""Largest number of files in an archive."""

LARGEST_RATIO = 100
"""Largest ratio of unpacked to packed size of an archive that unpacks to more than `SUSPICIOUS_CONTENT`."""

SUSPICIOUS_CONTENT = 64 << 20
"""Unpacked size up to which the ratio does not matter [bytes]."""


def sha256(path: Path) -> str:
    """Return the SHA-256 checksum of a file, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def unpack(path: Path, what: str) -> Path:
    """Return a folder with the content of a zip file; the same content gives the same folder, unpacked once.

    Parameters
    ----------
    path : the archive
    what : "FMU" or "SSP", for messages

    Raises
    ------
    InputError
        If the file is missing, is no zip file, or has entries that are not safe to unpack.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such {what} file")
    if not zipfile.is_zipfile(path):
        raise InputError(f"{path}: not a zip archive, so not an {what}")
    cached = cache_folder("unpacked")
    target = cached / sha256(path)[:32]
    if target.is_dir():
        if _is_whole(target, path):
            mark_used(target)
            return target
        with suppress(OSError):  # another process was faster
            target.rename(tempfile.mkdtemp(dir=cached, prefix="damaged-"))
    temporary = Path(tempfile.mkdtemp(dir=target.parent, prefix="unpacking-"))
    try:
        with zipfile.ZipFile(path) as archive:
            _check_entries(archive, path)
            archive.extractall(temporary)
        _check_description(temporary, path)
    except InputError:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    except Exception as error:  # a damaged archive makes zipfile and the decompressors raise whatever they like
        shutil.rmtree(temporary, ignore_errors=True)
        raise InputError(f"{path}: cannot be unpacked: {error or type(error).__name__}") from None
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    try:
        temporary.rename(target)
    except OSError:  # another process was faster
        shutil.rmtree(temporary, ignore_errors=True)
    return target


_FOLDER_ITSELF = ("./", ".\\")


def zip_faults(path: Path) -> list[Fault]:
    """Return what is odd about the entries of an archive though they can be unpacked."""
    with zipfile.ZipFile(path) as archive:
        odd = [name for name in archive.namelist() if name in _FOLDER_ITSELF]
    return [Fault(f"{path}: entry {name!r} is the folder itself") for name in odd]


def _is_whole(folder: Path, path: Path) -> bool:
    """Return whether a folder still has every file of an archive as it was packed."""
    try:
        with zipfile.ZipFile(path) as archive:
            entries = [e for e in archive.infolist() if not e.is_dir() and e.filename not in _FOLDER_ITSELF]
            return all(zlib.crc32((folder / e.filename.replace("\\", "/")).read_bytes()) == e.CRC for e in entries)
    except (OSError, zipfile.BadZipFile):
        return False


def _check_entries(archive: zipfile.ZipFile, path: Path) -> None:
    """Refuse absolute names, names with `..`, names that come twice, links, and contents that are too large."""
    entries = archive.infolist()
    if len(entries) > LARGEST_COUNT:
        raise InputError(f"{path}: holds {len(entries)} files; at most {LARGEST_COUNT} are accepted")
    names: set[str] = set()
    for entry in entries:
        name = PurePosixPath(entry.filename.replace("\\", "/"))
        if entry.filename in _FOLDER_ITSELF:
            continue
        if not name.parts or name.is_absolute() or ".." in name.parts or ":" in name.parts[0]:
            raise InputError(f"{path}: entry {entry.filename!r} would be unpacked outside the folder; refused")
        if str(name) in names:
            raise InputError(f"{path}: holds two entries {entry.filename!r}; refused")
        names.add(str(name))
        kind = stat.S_IFMT(entry.external_attr >> 16)
        if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
            what = "a link" if kind == stat.S_IFLNK else "no file"
            raise InputError(f"{path}: entry {entry.filename!r} is {what}; refused")
    total = sum(entry.file_size for entry in entries)
    if total > LARGEST_CONTENT:
        raise InputError(f"{path}: unpacks to {total / 2**30:.1f} GiB; at most {LARGEST_CONTENT >> 30} are accepted")
    ratio = total / path.stat().st_size
    if total > SUSPICIOUS_CONTENT and ratio > LARGEST_RATIO:
        raise InputError(
            f"{path}: unpacks to {total / 2**20:.0f} MiB, {ratio:.0f} times its size; at most {LARGEST_RATIO} times is "
            "accepted"
        )


def _check_description(folder: Path, path: Path) -> None:
    """Refuse a model description with a document type declaration, and so with entities, before anybody reads it."""
    file = folder / "modelDescription.xml"
    if not file.is_file():
        return
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        document = etree.parse(file, parser)
    except etree.XMLSyntaxError:
        return  # whoever opens the FMU says what is wrong with it
    if document.docinfo.internalDTD is not None:
        raise InputError(f"{path}: modelDescription.xml has a document type declaration; refused")
