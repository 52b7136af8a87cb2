# Appends the digest of a kernel's SPIR-V, as written by the compiler into a header, to that header.
#   cmake -DHEADER= -DSYMBOL= -P AppendDigest.cmake
file(SHA256 ${HEADER} digest)
file(APPEND ${HEADER} "constexpr char ${SYMBOL}_digest[] = \"${digest}\";\n")
