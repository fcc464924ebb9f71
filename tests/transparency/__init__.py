"""Whether a program can tell that it is instrumented: it is run plain and instrumented, compared.

    make test-transparency                     what takes minutes, with the report
    make test-transparency SUITES=all          everything
    python -m transparency SUITE[:PROGRAM]...  some of it (in the folder `tests`)

Suites are tables (``*.toml``) of programs, of the modules that are instrumented in them, and of the
differences that are expected, each with its reason; one that is expected and not found is a
failure, too.
"""
