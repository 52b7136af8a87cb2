// A glTF file and the files it names, read safely: nothing outside its folder, nothing larger than the file says.
#pragma once

#include "scene/file_io.h"
#include "scene/gltf/json_view.h"

#include <tiny_gltf.h>

namespace cmpg {

class GltfDocument {
  public:
    explicit GltfDocument(const std::filesystem::path& file);
    GltfDocument(const GltfDocument&) = delete; // views point into it
    GltfDocument& operator=(const GltfDocument&) = delete;

    // What the file holds, but for its images. Every value has passed checkGltf(): types, ranges and indices are right, buffers
    // have the length they declare, and buffer views lie within them.
    const tinygltf::Model& model() const { return model_; }
    std::span<const std::uint8_t> bufferView(int i) const;
    // The file of images[i], as stored.
    Bytes imageBytes(std::uint32_t i) const;

    // The JSON it was read from.
    JsonView root() const { return {&json_, name_, ""}; }
    const Json& json() const { return json_; }
    const std::string& name() const { return name_; }
    const std::filesystem::path& folder() const { return folder_; }

    // What a `uri` stands for: a data: URI or a file inside the scene's folder.
    Bytes readUri(const JsonView& uri) const;
    // The file itself and those that it names inside its folder.
    std::vector<std::filesystem::path> files() const;
    // The file of a `uri` that is not data:, checked to lie inside the folder (symbolic links followed). It may not exist.
    std::filesystem::path resolve(const JsonView& uri) const;

    // For complaints about the model: at("nodes[3]").fail(...).
    JsonView at(const std::string& place) const { return {nullptr, name_, place}; }

  private:
    void parseBinary(const Bytes& file);
    void parseJson(const char* first, const char* last);
    void checkVersionAndExtensions() const;
    void readBuffers();
    void buildModel();

    std::string name_; // as given by the user, for messages
    std::filesystem::path file_, folder_; // links followed
    Json json_;
    Bytes binaryChunk_; // of a .glb
    bool hasBinaryChunk_ = false;
    std::vector<Bytes> buffers_; // until the model takes them
    tinygltf::Model model_;
};

bool isDataUri(const std::string& uri);
bool supportsExtension(const std::string& name);

} // namespace cmpg
