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

set -- -e ".[dev,groot,learn,ray,record,view]"
for package in plugins/*/pyproject.toml; do
    [ -f "$package" ] && set -- "$@" -e "$(dirname "$package")"
done
log=.venv/setup.log
: >"$log"

# Run pip with its output in the log; a terminal shows its last step.
install() {
    .venv/bin/python -m pip install --disable-pip-version-check -c constraints.txt "$@" \
        >>"$log" 2>&1 </dev/null &
    pip=$!
    trap 'kill "$pip" 2>/dev/null; exit 130' INT TERM
    if [ -t 1 ]; then
        while kill -0 "$pip" 2>/dev/null; do
            step=$(grep -E '^ *(Collecting|Downloading|Building|Installing)' "$log" | tail -n 1)
            printf '\r\033[K  %.70s' "${step#"${step%%[! ]*}"}"
            sleep 1
        done
        printf '\r\033[K'
    fi
    if ! wait "$pip"; then
        tail -n 5 "$log" >&2
        echo "Packages cannot be installed; pip's output is in $log" >&2
        exit 1
    fi
}

echo "Installing packages into .venv: a minute or two (log: $log)"
# The tools that build packages come from the constraints too, so nothing is built in isolation.
install hatchling
install --no-build-isolation "$@"
touch .venv/.ready
echo "Ready: 'source .venv/bin/activate' makes bt-manip a command of your shell"
