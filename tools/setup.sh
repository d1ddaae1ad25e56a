#!/bin/sh
# Make .venv with the exact packages of constraints.txt and the project itself in it.
#
# PYTHON=/path/to/python3.12 chooses the interpreter; otherwise one is looked for.
set -eu
cd "$(dirname "$0")/.."

WANTED="3.11 or 3.12 (dm-control's labmaze has wheels for these two only)"

# Whether a command is a Python that will do; shims of version managers may exist and not work.
suits() {
    "$1" -c 'import sys, ensurepip, venv
sys.exit(sys.version_info[:2] not in ((3, 11), (3, 12)))' >/dev/null 2>&1
}

candidates() {
    if [ -n "${PYTHON:-}" ]; then
        echo "$PYTHON"
        return
    fi
    printf '%s\n' python3.12 python3.11 python3 python
    for root in "${PYENV_ROOT:-$HOME/.pyenv}/versions" "$HOME/.local/share/uv/python" \
        "$HOME/.asdf/installs/python" "$HOME/.local/share/mise/installs/python"; do
        for found in "$root"/*3.12*/bin/python3 "$root"/*3.11*/bin/python3; do
            [ -x "$found" ] && echo "$found"
        done
    done
    return 0
}

find_python() {
    candidates | while IFS= read -r candidate; do
        if suits "$candidate"; then
            echo "$candidate"
            return
        fi
    done
}

python=$(find_python)
if [ -z "$python" ]; then
    {
        echo "bt-manip needs Python $WANTED."
        for name in ${PYTHON:-python3 python3.12 python3.11}; do
            if ! version=$("$name" --version 2>&1); then
                continue
            fi
            if "$name" -c 'import ensurepip, venv' >/dev/null 2>&1; then
                echo "  $name is $version"
            else
                echo "  $name is $version, without venv (on Debian: apt install python3-venv)"
            fi
        done
        echo "Install one, or say where it is: make setup PYTHON=/path/to/python3.12"
    } >&2
    exit 1
fi

# An environment of another Python, or one that moved or broke, is made anew.
if ! suits .venv/bin/python || ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
    echo "Making .venv with $("$python" --version)"
    "$python" -m venv --clear .venv
fi

set -- -e ".[dev]"
for package in plugins/*/pyproject.toml; do
    [ -f "$package" ] && set -- "$@" -e "$(dirname "$package")"
done
export PIP_DISABLE_PIP_VERSION_CHECK=1
# The tools that build packages come from the constraints too, so nothing is built in isolation.
.venv/bin/python -m pip install --quiet -c constraints.txt hatchling
.venv/bin/python -m pip install --quiet -c constraints.txt --no-build-isolation "$@"
touch .venv/.ready
