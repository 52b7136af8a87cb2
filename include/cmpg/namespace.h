// Where the library's classes are. Programs write cmpg::Scene; v1, the version of the interface, keeps the name apart from the class of the same
// name inside the library, whose own sources (CMPG_SOURCES) write v1::Scene.
#pragma once

#ifdef CMPG_SOURCES
namespace cmpg::v1 {}
#else
namespace cmpg {
inline namespace v1 {}
} // namespace cmpg
#endif
