#!/bin/sh
# Install packages, given as arguments of pip, into an environment other than .venv: with uv, which
# links files that environments have in common, or with pip where uv cannot.
#
#     sh tools/install_into.sh FOLDER ARGUMENT...
set -eu
cd "$(dirname "$0")/.."
folder=$1
shift
log=$folder/setup.log
. tools/installers.sh

if [ "${INSTALLER:-uv}" = uv ] && run .venv/bin/uv --version; then
    configure_uv
    with_uv "$@" && exit
fi
with_pip --no-compile "$@" || {
    tail -n 5 "$log" >&2
    exit 1
}
