// A glTF file and the files it names, read safely: nothing outside its folder, nothing larger than the file says.
#pragma once

#include "scene/file_io.h"
#include "scene/json_view.h"

#include <map>

namespace cmpg {

class GltfDocument {
  public:
    explicit GltfDocument(const std::filesystem::path& file);
    GltfDocument(const GltfDocument&) = delete; // views point into it
    GltfDocument& operator=(const GltfDocument&) = delete;

    JsonView root() const { return {&json_, name_, ""}; }
    const Json& json() const { return json_; }
    const std::string& name() const { return name_; }
    const std::filesystem::path& folder() const { return folder_; }

    // Bytes of buffers[i] and bufferViews[i], read when first asked for and checked against their declared lengths.
    std::span<const std::uint8_t> buffer(std::uint32_t i);
    std::span<const std::uint8_t> bufferView(std::uint32_t i);

    // What a `uri` stands for: a data: URI or a file inside the scene's folder.
    Bytes readUri(const JsonView& uri) const;
    // The file of a `uri` that is not data:, checked to lie inside the folder (symbolic links followed). It may not exist.
    std::filesystem::path resolve(const JsonView& uri) const;

  private:
    void parseBinary(const Bytes& file);
    void parseJson(const char* first, const char* last);
    void checkVersionAndExtensions() const;

    std::string name_; // as given by the user, for messages
    std::filesystem::path folder_;
    Json json_;
    Bytes binaryChunk_; // of a .glb
    bool hasBinaryChunk_ = false;
    std::map<std::uint32_t, Bytes> buffers_;
};

bool isDataUri(const std::string& uri);
bool supportsExtension(const std::string& name);

} // namespace cmpg
