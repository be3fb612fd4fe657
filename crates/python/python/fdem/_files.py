"""Files that are written whole or not at all."""

from __future__ import annotations

import errno
import os
import pathlib
import tempfile


def write_whole(target: pathlib.Path, content: bytes) -> None:
    """Writes a file whole or not at all: other processes see the old contents or the new ones."""
    if target.exists() and not target.is_file():
        # A pipe or a device cannot be replaced.
        target.write_bytes(content)
        return
    target = pathlib.Path(os.path.realpath(target)) if target.is_symlink() else target
    if not target.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "there is no such folder", str(target.parent))
    # Aside first: a full disk leaves the old file as it was.
    with tempfile.NamedTemporaryFile(dir=target.parent, prefix=target.name, delete=False) as aside:
        try:
            aside.write(content)
            aside.close()
            # With the rights of any file that is created, and not those of its owner alone.
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(aside.name, 0o666 & ~mask)
            os.replace(aside.name, target)
        except BaseException:
            os.unlink(aside.name)
            raise
