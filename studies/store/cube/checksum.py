"""The checksum of a block's values, kept with its done-mark."""

import hashlib
from collections.abc import Mapping

import numpy as np


def checksum(values: Mapping[str, np.ndarray]) -> str:
    """Hash the values of a block, before they are encoded and after they were read back.

    Parameters
    ----------
    values : mapping of array
        Every stored variable, in the type in which it is stored; their order does not count.

    Returns
    -------
    str
        BLAKE2b of 16 bytes in hexadecimal. Equal for equal bits: of two NaN, the kind counts.
    """
    digest = hashlib.blake2b(digest_size=16)
    for name in sorted(values):
        array = np.ascontiguousarray(values[name])
        little = array.astype(array.dtype.newbyteorder("<"), copy=False)
        digest.update(f"{name} {little.dtype.str} {little.shape}\n".encode())
        digest.update(little.tobytes())
    return digest.hexdigest()
