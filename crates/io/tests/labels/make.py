"""Labelled images of other programs: `python3 make.py` in this folder, with numpy, tifffile and imagecodecs, rewrites them.

All hold the numbers 0 to 59 times 2 in 3 planes of 4 rows of 5, or the first plane of it; those of 32 bits times 1000.
"""

import numpy as np
import tifffile

labels = (np.arange(60).reshape(3, 4, 5) * 2).astype("u2")
np.save("plain.npy", labels)
np.save("fortran.npy", np.asfortranarray(labels.astype(">i4")))
np.savez("stored.npz", labels=labels, other=labels[0].astype("i8"))
np.savez_compressed("deflated.npz", labels.astype("i2"))
tifffile.imwrite("stack.tif", labels, photometric="minisblack", metadata=None)
tifffile.imwrite("page.tif", labels[0].astype("u1"), photometric="minisblack", metadata=None)
tifffile.imwrite("imagej.tif", labels, imagej=True)
# As ImageJ writes stacks of more than 4 GB: one header, the other pages behind the first.
tifffile.imwrite("imagej_contiguous.tif", labels, imagej=True, bigtiff=False, contiguous=True, truncate=True, ome=False)
tifffile.imwrite("big_endian.tif", labels.astype("u4") * 500, photometric="minisblack", byteorder=">", bigtiff=True, metadata=None)
tifffile.imwrite("lzw.tif", labels, photometric="minisblack", compression="lzw", predictor=True, rowsperstrip=2, metadata=None)
tifffile.imwrite("deflate_tiles.tif", np.pad(labels, ((0, 0), (0, 20), (0, 20))), photometric="minisblack", compression="zlib", tile=(16, 16), metadata=None)
tifffile.imwrite("packbits.tif", labels.astype("u1"), photometric="minisblack", compression="packbits", metadata=None)
tifffile.imwrite("signed.tif", labels.astype("i2") - 60, photometric="minisblack", metadata=None)
tifffile.imwrite("float.tif", labels.astype("f4"), photometric="minisblack", metadata=None)
tifffile.imwrite("white_is_zero.tif", labels.astype("u1"), photometric="miniswhite", metadata=None)
tifffile.imwrite("colour.tif", np.zeros((4, 5, 3), "u1"), photometric="rgb", metadata=None)
with tifffile.TiffWriter("two_sizes.tif") as out:
    out.write(labels[0], photometric="minisblack", metadata=None)
    out.write(labels[0, :3], photometric="minisblack", metadata=None)
