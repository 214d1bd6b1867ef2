#!/bin/sh
# What pip cannot install: Python's venv module, and the libraries that Gmsh and VTK load.
# Installs what is missing when run as root on Debian or Ubuntu; otherwise says what to ask for.
set -eu
python=${1:-python3}

"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || {
    echo "femic needs Python 3.11 or newer; '$python' is not. Try: make PYTHON=/path/to/python3.11" >&2
    exit 1
}

missing=""
need() { missing="$missing $1"; }

"$python" -c 'import ensurepip, venv' 2>/dev/null || need python3-venv
known=$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p)
while read -r library package; do
    case "$known" in *"$library"*) ;; *) need "$package" ;; esac
done <<LIBRARIES
libGLU.so.1 libglu1-mesa
libGL.so.1 libgl1
libXcursor.so.1 libxcursor1
libXft.so.2 libxft2
libXinerama.so.1 libxinerama1
libXrender.so.1 libxrender1
libgomp.so.1 libgomp1
libEGL.so.1 libegl1
LIBRARIES

[ -z "$missing" ] && exit 0
command="apt-get install -y --no-install-recommends$missing"
if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then
    echo "Missing system packages. Ask your administrator for (names of Debian and Ubuntu):" >&2
    echo "    $command" >&2
    exit 1
fi
echo "installing system packages:$missing"
apt-get update -qq
DEBIAN_FRONTEND=noninteractive $command >/dev/null
