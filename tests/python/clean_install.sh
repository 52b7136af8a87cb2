#!/usr/bin/env bash
# As docs/python.md says it, on a machine that has what scripts/install --python brings: a new environment, pip install, the example.
#   tests/python/clean_install.sh SOURCE
set -euo pipefail
source=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
/usr/bin/python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check "$source"
cd "$folder" # so that nothing is found in the source by chance
"$folder/env/bin/python" "$source/python/examples/recover_painting.py" 3 "$folder/out"
test -s "$folder/out/painting.png"
"$folder/env/bin/python" - "$folder" <<'PYTHON'
import pathlib, sys, cmpg
installed = pathlib.Path(cmpg.__file__).parent
assert str(installed).startswith(sys.argv[1]), installed
assert {"_cmpg.pyi", "py.typed", "torch.py"} <= {f.name for f in installed.iterdir()}
PYTHON
