"""What long work shares: all cores or a cluster, finished results that are found again, tables of what came of it."""
