# SPDX-License-Identifier: Apache-2.0
"""How the scripts beside this one run the case that the command line names, in a folder of its own."""
import shutil
import sys
import tempfile


def run_case(cases):
    for case in cases:
        if case.__name__ == sys.argv[1]:
            folder = tempfile.mkdtemp(prefix="scanmill-")
            try:
                case(folder)
            finally:
                shutil.rmtree(folder)
            return
    sys.exit(f"no case {sys.argv[1]}")
