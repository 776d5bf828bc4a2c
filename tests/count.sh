#!/bin/sh
# count.sh LOG: how many tests a CTest run held, from its LastTest.log: CTest's entries, and doctest's cases in them.
awk '
  /^Test (Passed|Failed)/ { ++entries }
  /^\[doctest\] test cases:/ { cases += $4 }
  /^\[doctest\] assertions:/ { assertions += $3 }
  END { printf "%d tests run: %d test cases with %d assertions, and the install, consumer and header checks\n",
        entries, cases, assertions }' "$1"
