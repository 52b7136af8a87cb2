// Text in UTF-8.
#pragma once

namespace cmpg {

// Whether a byte goes on with the character of the byte before.
inline bool continuesCharacter(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

} // namespace cmpg
