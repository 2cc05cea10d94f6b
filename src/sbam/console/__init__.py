"""How the command line talks: reports, tables, progress and errors."""
