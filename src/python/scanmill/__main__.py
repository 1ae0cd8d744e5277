"""`python -m scanmill`: the program, where the package has it."""

from scanmill.program import main

if __name__ == "__main__":
    main()
