"""The panel of the Slicer module, shown in a browser: `sdfstent app`.

The module's own logic and panel run here, on the MRML of the package `slicer-core`, without Slicer
and without Qt. What a page shows is read from the panel's `.ui` file. `serving` is the server,
`page` the process behind one page.
"""
