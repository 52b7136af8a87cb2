// glTF and .glb scenes, with what the renderer makes of them on the host.
#include "scene_folder.h"
#include "support/scene_mutation.h"

using namespace cmpg;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::SceneFolder folder("scene.gltf");
    const auto file = folder.holding({data, size});
    fuzz::accepts({ErrorKind::Input}, [&] { fuzz::useScene(file); });
    return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

// Bytes of any file; of a .gltf mostly values of its JSON instead.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    const auto brackets = std::count(data, data + size, '[') + std::count(data, data + size, '{');
    if (seed % 4 == 0 || brackets > 1000) // its depth is a recursion's
        return LLVMFuzzerMutate(data, size, most);
    nlohmann::json json = nlohmann::json::parse(data, data + size, nullptr, false);
    if (!json.is_object())
        return LLVMFuzzerMutate(data, size, most);
    test::SceneMutation mutation(seed);
    for (unsigned i = 0; i <= seed / 4 % 3; ++i)
        mutation.apply(json);
    const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (text.size() > most)
        return LLVMFuzzerMutate(data, size, most);
    std::copy(text.begin(), text.end(), data);
    return text.size();
}
