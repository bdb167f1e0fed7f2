"""Renew the copy: ``python -m tests.service.contract``; what breaks clients only with ``--break "why, and what to do"``."""

import argparse
import sys

from tests.service.contract import COPY, NOTES, document_now, keep, promised, promised_before
from tests.service.contract.breaks import breaks


def main() -> None:
    """Write the copy anew where nothing breaks, or where a reason is given."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--break", dest="reason", help="why clients are broken, and what they do instead")
    reason = parser.parse_args().reason
    now = document_now()
    broken = breaks(promised_before(), promised(now)) if COPY.exists() else []
    for line in broken:
        print(line)
    if broken and not reason:
        sys.exit(
            'Clients would break. Keep what they use, or say why not: --break "…"; the note is reviewed.'
        )
    if broken:
        with NOTES.open("a") as notes:
            notes.write(f"\n## {reason}\n\n" + "".join(f"- {line}\n" for line in broken))
    keep(now)


if __name__ == "__main__":
    main()
