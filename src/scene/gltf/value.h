// Numbers, vectors and members out of the parts of a tinygltf model that any JSON may stand in; absent ones give the fallback.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <tiny_gltf.h>

namespace cmpg {

inline const tinygltf::Value& member(const tinygltf::Value& object, const char* key) {
    static const tinygltf::Value kNone;
    return object.Has(key) ? object.Get(key) : kNone;
}
inline const tinygltf::Value& extension(const tinygltf::ExtensionMap& extensions, const char* name) {
    static const tinygltf::Value kNone;
    const auto found = extensions.find(name);
    return found == extensions.end() ? kNone : found->second;
}
inline double number(const tinygltf::Value& value, double fallback) { return value.IsNumber() ? value.GetNumberAsDouble() : fallback; }
inline float real(const tinygltf::Value& value, float fallback) { return float(number(value, fallback)); }
inline std::string text(const tinygltf::Value& value) { return value.IsString() ? value.Get<std::string>() : std::string(); }

template <int N, class T> glm::vec<N, T> vec(const std::vector<double>& values, glm::vec<N, T> fallback) {
    if (values.size() == N)
        for (int i = 0; i < N; ++i) fallback[i] = T(values[std::size_t(i)]);
    return fallback;
}
template <int N, class T> glm::vec<N, T> vec(const tinygltf::Value& values, glm::vec<N, T> fallback) {
    if (values.ArrayLen() == N)
        for (int i = 0; i < N; ++i) fallback[i] = T(values.Get(i).GetNumberAsDouble());
    return fallback;
}

} // namespace cmpg
