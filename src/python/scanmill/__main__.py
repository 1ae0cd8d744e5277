"""Runs the program with `python -m scanmill`, if the package contains the program."""

from scanmill.program import main

if __name__ == "__main__":
    main()
