#!/bin/sh
# Make .venv with the exact packages of constraints.txt and the project itself in it.
#
# "setup.sh docs" adds the packages of an extra to it.
# PYTHON=/path/to/python3.13 chooses the interpreter; otherwise one is looked for.
# INSTALLER=pip installs with pip; otherwise uv installs, where it runs.
set -eu
cd "$(dirname "$0")/.."

WANTED="3.11 to 3.14"

# Whether a command is a Python that will do; shims of version managers may exist and not work.
suits() {
    "$1" -c 'import sys, ensurepip, venv
sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' >/dev/null 2>&1
}

candidates() {
    if [ -n "${PYTHON:-}" ]; then
        echo "$PYTHON"
        return
    fi
    printf '%s\n' python3.12 python3.11 python3.13 python3.14 python3 python
    for root in "${PYENV_ROOT:-$HOME/.pyenv}/versions" "$HOME/.local/share/uv/python" \
        "$HOME/.asdf/installs/python" "$HOME/.local/share/mise/installs/python"; do
        for version in 3.12 3.11 3.13 3.14; do
            for found in "$root"/*"$version"*/bin/python3; do
                [ -x "$found" ] && echo "$found"
            done
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

# Let uv fetch a Python, into the folder where `candidates` finds it; pip fetches uv itself.
fetch_python() {
    uv=$(command -v uv) || {
        uv=.venv/bin/uv
        python3 -m venv --clear .venv &&
            .venv/bin/python -m pip install -q --disable-pip-version-check -c constraints.txt uv
    } >/dev/null 2>&1 || return
    echo "No Python $WANTED found: uv fetches Python 3.12 into ~/.local/share/uv/python"
    "$uv" python install --install-dir "$HOME/.local/share/uv/python" 3.12
}

python=$(find_python)
if [ -z "$python" ] && [ -z "${PYTHON:-}" ] && fetch_python; then
    python=$(find_python)
fi
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
        echo "Install one, or say where it is: make setup PYTHON=/path/to/python3.13"
    } >&2
    exit 1
fi

# An environment of another Python, or one that moved or broke, is made anew.
if ! suits .venv/bin/python || ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
    echo "Making .venv with $("$python" --version)"
    "$python" -m venv --clear .venv
fi

if [ $# -gt 0 ]; then
    set -- -e ".[$1]"
else
    set -- -e ".[dev,learn]"
    for package in plugins/*/pyproject.toml; do
        [ -f "$package" ] && set -- "$@" -e "$(dirname "$package")"
    done
fi
folder=.venv
log=$folder/setup.log
: >"$log"
. tools/installers.sh

# The tools that build packages come from the constraints too, so nothing is built in isolation.
install() {
    with=$1
    shift
    "$with" -c constraints.txt hatchling && "$with" -c constraints.txt --no-build-isolation "$@"
}

# From 3.13 on, labmaze is left out as pyproject.toml tells uv. pip is told no such thing: it gets
# the whole list without it.
install_with_pip() {
    case $(.venv/bin/python --version) in
        "Python 3.11"* | "Python 3.12"*) install with_pip "$@" ;;
        *)
            grep -v '^labmaze==' constraints.txt >.venv/pinned.txt
            with_pip -c constraints.txt --no-deps -r .venv/pinned.txt &&
                with_pip -c constraints.txt --no-deps --no-build-isolation "$@"
            ;;
    esac
}

echo "Installing packages into .venv (log: $log)"
if [ "${INSTALLER:-uv}" = uv ] && with_pip -c constraints.txt uv && run .venv/bin/uv --version; then
    configure_uv
    if ! install with_uv "$@"; then
        echo "uv cannot install the packages; pip tries, which takes a minute or two"
        INSTALLER=pip
    fi
else
    INSTALLER=pip
fi
if [ "${INSTALLER:-uv}" = pip ] && ! install_with_pip "$@"; then
    tail -n 5 "$log" >&2
    echo "Packages cannot be installed; pip's output is in $log" >&2
    exit 1
fi
touch .venv/.ready
echo "Ready: 'source .venv/bin/activate' makes bt-manip a command of your shell"
