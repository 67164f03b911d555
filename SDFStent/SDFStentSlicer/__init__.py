"""The Slicer half of SDFStent: nodes, panel and display around the library SDFStentLib."""
