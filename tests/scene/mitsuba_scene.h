// Small Mitsuba scenes made by the tests, and how they are refused.
#pragma once

#include "gltf_writer.h"

namespace cmpg::test {

inline fs::path save(const TempFolder& folder, const std::string& text, const std::string& name = "scene.xml") {
    std::ofstream(folder / name) << text;
    return folder / name;
}

inline Scene loadText(const TempFolder& folder, const std::string& contents, const LoadOptions& options = {}, const std::string& version = "3.0.0") {
    return loadScene(save(folder, "<scene version=\"" + version + "\">\n" + contents + "\n</scene>\n"), options);
}

inline const std::string kSquare = "<shape type=\"rectangle\"><bsdf type=\"twosided\" id=\"wall\"><bsdf type=\"diffuse\">"
                                   "<rgb name=\"reflectance\" value=\"0.1, 0.2 0.3\"/></bsdf></bsdf></shape>";

// The message of what loading throws.
inline std::string refusal(const TempFolder& folder, const std::string& contents, const LoadOptions& options = {}) {
    try {
        loadText(folder, contents, options);
    } catch (const Error& e) {
        EXPECT_EQ(e.kind, ErrorKind::Input) << e.what();
        return std::string(e.what()) + " | " + e.remedy;
    }
    return "";
}

inline void expectRefused(const TempFolder& folder, const std::string& contents, const std::string& part, int line = 2) {
    const std::string message = refusal(folder, contents);
    EXPECT_NE(message.find("scene.xml:" + std::to_string(line) + ": "), std::string::npos) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
}

} // namespace cmpg::test
