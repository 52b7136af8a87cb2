// A scene and a renderer of the library's surface as the options want them: what commands that make images and derivatives start from.
#pragma once

#include "session/exit_status.h"
#include "session/session.h"

#include <cmpg/renderer.h>

namespace cmpg {

class RenderSession : public Session {
  public:
    using Session::Session;

    // Opens the device and has kernels made for passes of these kinds: after all other input was checked. Then as begin().
    void prepare(const SeenView& view, const std::filesystem::path& folder, std::initializer_list<v1::PassKind> kinds);
    v1::Renderer& renderer() { return *renderer_; }

    // A pass of the options, of `spp` samples per pixel, with their budget and learning passes.
    v1::PassOptions pass(std::uint32_t spp) const;
    // One without either, whose random numbers are those of --seed.
    v1::PassOptions plainPass(std::uint32_t spp) const;

    // Of the pass that the command is for: tells how it was drawn, saves its guide and its layers.
    void tell(const v1::PassReport& pass);
    // Where it was sampled in batches: prints its error, adds it to the report, and writes the samples that were taken to run.json, where
    // `samples` is the option for them. CheckFailed where there is an error target that was not reached.
    ExitStatus conclude(const v1::PassReport& pass, std::optional<std::uint32_t> Options::* samples);

  private:
    std::optional<v1::Renderer> renderer_;
    std::string camera_;
    int width_ = 0, height_ = 0;
};

} // namespace cmpg
