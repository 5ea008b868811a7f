"""Loop closing: submaps and key scans, the constraints between them, and the globally consistent map."""
