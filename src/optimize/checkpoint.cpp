// All that an optimisation needs to go on as if it had not ended.
#include "optimize/checkpoint.h"

#include "base/error.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace cmpg {
namespace {

void put(ByteWriter& out, const Checkpoint::Identity& identity) {
    out.count(identity.size());
    for (const auto& [name, value] : identity) {
        out.put(name);
        out.put(value);
    }
}

Checkpoint::Identity getIdentity(ByteReader& in) {
    Checkpoint::Identity identity(in.count(2 * 8));
    for (auto& [name, value] : identity) {
        name = in.text();
        value = in.text();
    }
    return identity;
}

void put(ByteWriter& out, const OptimizeState& state) {
    out.put(state.step);
    out.count(state.moments.size());
    for (const Moments& m : state.moments) {
        out.put(m.unit);
        out.put(m.start);
        out.put(m.first);
        out.put(m.second);
        out.put(m.peak);
        out.put(std::uint8_t(m.seen != nullptr));
        if (m.seen)
            m.seen->save(out);
        out.put(std::uint8_t(m.expected != nullptr));
        if (m.expected)
            for (const std::vector<float>* differences : {&m.expected->right, &m.expected->below})
                out.put(*differences);
        out.put(m.products);
        out.put(m.steps);
        out.count(m.noise.size());
        for (const SignalNoise& noise : m.noise) {
            out.put(noise.squares);
            out.put(noise.signal);
            out.put(noise.noise);
        }
    }
    out.put(state.constants.matrix);
    out.put(state.constants.noise);
    out.put(state.constants.others);
    out.put(state.constants.at);
    for (const std::vector<double>* values : {&state.carried.mean, &state.carried.variance, &state.carried.squares})
        out.put(*values);
    out.put(state.carried.at);
    out.count(state.cross.size());
    for (const CrossCurvature& cross : state.cross)
        out.put(cross.below);
    out.count(state.losses.size());
    for (const ViewLoss& loss : state.losses) {
        out.put(loss.value);
        out.put(loss.error);
        out.put(std::uint8_t(loss.known));
    }
    out.count(state.history.size());
    for (const StepRecord& r : state.history) {
        for (const double value : {r.loss, r.lossError, r.regularizer, r.rate, r.secondsPrimal, r.secondsGradient, r.secondsUpdate, r.gradientNorm})
            out.put(value);
        out.put(r.dropped);
    }
}

void put(ByteWriter& out, const RunningImage& image) {
    out.put(std::uint32_t(image.half[0].width));
    out.put(std::uint32_t(image.half[0].height));
    for (const Image& half : image.half)
        out.put(half.values);
    out.put(image.used);
    out.count(image.samples.size());
    for (const std::uint32_t samples : image.samples)
        out.put(samples);
    out.put(image.paths);
    out.put(image.worth);
    out.put(std::uint32_t(image.method));
    out.put(image.differenceVariance);
    out.put(image.covariance);
    out.put(image.differences);
}

template <class T> std::vector<T> finite(std::vector<T> values, const char* what) {
    if (!std::all_of(values.begin(), values.end(), [](T value) { return std::isfinite(value); }))
        throw Malformed{std::string(what) + " is not finite"};
    return values;
}

RunningImage getRunningImage(ByteReader& in) {
    RunningImage image;
    const auto width = in.get<std::uint32_t>(), height = in.get<std::uint32_t>();
    for (Image& half : image.half) {
        half.width = int(width);
        half.height = int(height);
        half.channels = 3;
        half.values = in.reals<float>();
        if (half.values.size() != std::uint64_t(width) * height * 3)
            throw Malformed{"an image has another size than it says"};
    }
    image.used = in.get<std::uint32_t>();
    image.samples.resize(in.count(sizeof(std::uint32_t)));
    for (std::uint32_t& samples : image.samples)
        samples = in.get<std::uint32_t>();
    if (image.samples.size() != std::uint64_t(width) * height ||
        std::any_of(image.samples.begin(), image.samples.end(), [&](std::uint32_t s) { return s > image.used; }))
        throw Malformed{"the samples of an image do not fit"};
    image.paths = in.get<std::uint64_t>();
    image.worth = in.reals<float>();
    if (image.worth.size() != std::uint64_t(width) * height || !std::all_of(image.worth.begin(), image.worth.end(), [](float w) { return w > 0 && std::isfinite(w); }))
        throw Malformed{"the samples that an image is worth do not fit"};
    image.method = Sampling(in.get<std::uint32_t>());
    if (image.method >= Sampling::Auto)
        throw Malformed{"an image was drawn by an unknown method"};
    image.differenceVariance = in.figure("the variance of a difference");
    image.covariance = in.real();
    if (!std::isfinite(image.covariance))
        throw Malformed{"the covariance of an image is not finite"};
    image.differences = in.get<std::uint32_t>();
    return image;
}

OptimizeState getState(ByteReader& in) {
    OptimizeState state;
    state.step = in.get<std::uint32_t>();
    state.moments.resize(in.count(4 + 4 + 3 * 8 + 2 + 4 + 4 + 8));
    for (Moments& m : state.moments) {
        m.unit = in.single();
        m.start = in.get<std::uint32_t>();
        for (std::vector<float>* values : {&m.first, &m.second, &m.peak})
            *values = finite(in.reals<float>(), "what is remembered of a gradient");
        if (in.get<std::uint8_t>() != 0) {
            auto seen = std::make_shared<SeenTexels>();
            seen->restore(in, m.second.size());
            m.seen = std::move(seen);
        }
        if (in.get<std::uint8_t>() != 0) {
            auto expected = std::make_shared<ExpectedDifferences>();
            for (std::vector<float>* differences : {&expected->right, &expected->below}) {
                *differences = finite(in.reals<float>(), "an expected difference of neighbours");
                if (differences->size() != m.second.size())
                    throw Malformed{"expected differences of neighbours do not fit"};
            }
            m.expected = std::move(expected);
        }
        m.products = in.get<std::uint32_t>();
        m.steps = in.get<std::uint32_t>();
        m.noise.resize(in.count(8 + 8 + 8));
        for (SignalNoise& noise : m.noise) {
            noise.squares = in.reals<float>();
            noise.signal = in.real();
            noise.noise = in.figure("the noise of a gradient");
            if (!std::isfinite(noise.signal))
                throw Malformed{"the signal of a gradient is not finite"};
        }
    }
    for (std::vector<double>* values : {&state.constants.matrix, &state.constants.noise, &state.constants.others})
        *values = finite(in.reals<double>(), "the curvature of constants");
    state.constants.at = in.reals<float>();
    for (std::vector<double>* values : {&state.carried.mean, &state.carried.variance, &state.carried.squares}) {
        *values = finite(in.reals<double>(), "the gradient of constants");
        if (values != &state.carried.mean && std::any_of(values->begin(), values->end(), [](double value) { return value < 0; }))
            throw Malformed{"the variance of the gradient of constants is negative"};
    }
    state.carried.at = in.reals<float>();
    state.cross.resize(in.count(8));
    for (CrossCurvature& cross : state.cross)
        cross.below = finite(in.reals<float>(), "the curvature of maps");
    state.losses.resize(in.count(8 + 8 + 1));
    for (ViewLoss& loss : state.losses) {
        loss.value = in.real();
        loss.error = in.real();
        loss.known = in.get<std::uint8_t>() != 0;
    }
    state.history.resize(in.count(9 * 8));
    for (StepRecord& r : state.history) {
        for (double* value : {&r.loss, &r.lossError, &r.regularizer, &r.rate, &r.secondsPrimal, &r.secondsGradient, &r.secondsUpdate, &r.gradientNorm})
            *value = in.real();
        r.dropped = in.get<std::uint64_t>();
    }
    if (state.history.size() > state.step) // fewer: it went on from another run
        throw Malformed{"it has more records of steps than steps"};
    return state;
}

std::vector<RunningImage> getImages(ByteReader& in) {
    std::vector<RunningImage> images(in.count(2 * 4 + 2 * 8 + 4 + 8 + 8 + 4 + 2 * 8 + 4));
    for (RunningImage& image : images)
        image = getRunningImage(in);
    return images;
}

template <class T> std::vector<std::vector<T>> getVectors(ByteReader& in) {
    std::vector<std::vector<T>> vectors(in.count(8));
    for (std::vector<T>& v : vectors)
        v = in.reals<T>();
    return vectors;
}

template <class T> void putVectors(ByteWriter& out, const std::vector<std::vector<T>>& vectors) {
    out.count(vectors.size());
    for (const std::vector<T>& v : vectors)
        out.put(v);
}

// Each set once, then the one of each view.
void putShared(ByteWriter& out, const std::vector<SharedValues>& values) {
    std::vector<SharedValues> sets;
    std::vector<std::uint32_t> places;
    for (const SharedValues& own : values) {
        const auto found = std::find(sets.begin(), sets.end(), own);
        places.push_back(own ? std::uint32_t(found - sets.begin()) : ~0u);
        if (own && found == sets.end())
            sets.push_back(own);
    }
    out.count(sets.size());
    for (const SharedValues& set : sets)
        putVectors(out, set->values);
    out.count(places.size());
    for (const std::uint32_t place : places)
        out.put(place);
}

std::vector<SharedValues> getShared(ByteReader& in) {
    std::vector<SharedValues> sets(in.count(8)), values;
    for (SharedValues& set : sets)
        set = std::make_shared<const StepValues>(StepValues{getVectors<float>(in)});
    values.resize(in.count(4));
    for (SharedValues& own : values) {
        const auto place = in.get<std::uint32_t>();
        if (place != ~0u && place >= sets.size())
            throw Malformed{"an image has values that are not there"};
        own = place == ~0u ? nullptr : sets[place];
    }
    return values;
}

template <class Write> FileSection section(const char* name, Write&& write) {
    ByteWriter out;
    write(out);
    return {name, std::move(out.bytes)};
}

const Bytes& bytesOf(const std::vector<FileSection>& sections, const char* name) {
    const auto found = std::find_if(sections.begin(), sections.end(), [&](const FileSection& s) { return s.name == name; });
    if (found == sections.end())
        throw Malformed{std::string("it has no section '") + name + "'"};
    return found->bytes;
}

template <class Read> auto readSection(const std::vector<FileSection>& sections, const char* name, Read&& read) {
    ByteReader in(bytesOf(sections, name));
    auto value = read(in);
    in.end();
    return value;
}

Error invalid(const Malformed& malformed) { return {ErrorKind::Input, "it is no valid checkpoint: " + malformed.what, "it was made by something else"}; }

} // namespace

std::vector<FileSection> checkpointSections(const Optimization& run, const ImageModel& model, const Checkpoint::Identity& identity,
                                            const std::string& config, const std::string& madeWith) {
    return {section("identity", [&](ByteWriter& out) { put(out, identity); }),
            section("config", [&](ByteWriter& out) { out.put(config); }),
            section("device", [&](ByteWriter& out) { out.put(madeWith); }),
            section("state", [&](ByteWriter& out) { put(out, run.state()); }),
            section("values",
                    [&](ByteWriter& out) {
                        out.count(run.parameters().size());
                        for (const std::uint32_t p : run.parameters())
                            out.put(run.scene().parameters[p].values);
                    }),
            section("images",
                    [&](ByteWriter& out) {
                        out.count(run.state().images.size());
                        for (const RunningImage& image : run.state().images)
                            put(out, image);
                        putShared(out, run.state().imageValues);
                        putVectors(out, run.state().pixelShares);
                    }),
            section("gradient", [&](ByteWriter& out) { putVectors(out, run.gradients()); }),
            section("learned", [&](ByteWriter& out) { model.save(out); })};
}

Checkpoint readCheckpoint(const std::vector<FileSection>& sections) {
    try {
        Checkpoint c;
        c.identity = readSection(sections, "identity", getIdentity);
        c.config = readSection(sections, "config", [](ByteReader& in) { return in.text(); });
        c.madeWith = readSection(sections, "device", [](ByteReader& in) { return in.text(); });
        c.state = readSection(sections, "state", getState);
        c.values = readSection(sections, "values", getVectors<float>);
        c.gradients = readSection(sections, "gradient", getVectors<double>);
        std::tie(c.state.images, c.state.imageValues, c.state.pixelShares) = readSection(sections, "images", [](ByteReader& in) {
            std::vector<RunningImage> images = getImages(in);
            std::vector<SharedValues> values = getShared(in);
            return std::tuple(std::move(images), std::move(values), getVectors<float>(in));
        });
        c.learned = bytesOf(sections, "learned");
        for (const std::vector<float>& shares : c.state.pixelShares)
            if (!std::all_of(shares.begin(), shares.end(), [](float share) { return share >= 0 && share < 1e9f; }))
                throw Malformed{"a share of the samples is none"};
        for (const std::vector<float>& values : c.values)
            if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); }))
                throw Malformed{"a value is not finite"};
        return c;
    } catch (const Malformed& malformed) {
        throw invalid(malformed);
    }
}

void resume(const Checkpoint& checkpoint, Optimization& run, ImageModel& model) {
    run.requireFits(checkpoint.state, checkpoint.values, checkpoint.gradients);
    try {
        ByteReader in(checkpoint.learned);
        model.restore(in, checkpoint.state.step);
    } catch (const Malformed& malformed) {
        throw invalid(malformed);
    }
    run.restore(checkpoint.state, checkpoint.values, checkpoint.gradients);
}

std::optional<Checkpoint> findCheckpoint(const std::filesystem::path& folder, std::vector<std::string>& refused) {
    for (const std::filesystem::path& file : checkpointFiles(folder)) {
        std::error_code ignored;
        if (!std::filesystem::exists(file, ignored))
            continue;
        try {
            return readCheckpoint(readCheckpointFile(file));
        } catch (const Error& error) {
            refused.push_back(file.string() + ": " + error.what() + (error.cause.empty() ? "" : " (" + error.cause + ")"));
        }
    }
    return std::nullopt;
}

} // namespace cmpg
