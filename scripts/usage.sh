# For scripts to source: what they are called with. A script's own comment, which it begins with, is what --help prints.

say_usage() { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; }

refuse() {
    echo "${0##*/}: $1; see $0 --help" >&2
    exit 2
}

# check_arguments OPTIONS WORDS "$@": of all options only those of OPTIONS, and at most so many words beside them.
check_arguments() {
    local known=$1 words=$2 argument
    shift 2
    for argument; do
        case $argument in
            -h | --help) say_usage; exit 0 ;;
            -*) [[ " $known " == *" $argument "* ]] || refuse "there is no option $argument" ;;
            *) ((words-- > 0)) || refuse "$argument is more than it takes" ;;
        esac
    done
}
