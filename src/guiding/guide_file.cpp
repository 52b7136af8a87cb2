// Guides on disk. Little endian: magic, version, bytes of content, content, FNV-1a of everything before.
#include "guiding/guide_file.h"

#include "base/error.h"
#include "scene/file_io.h"
#include "shared/guide.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>

namespace cmpg {
namespace {

constexpr std::uint64_t kMagic = 0x0a45444955475643; // "CVGUIDE\n"
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeaderBytes = 8 + 4 + 8, kChecksumBytes = 8;
constexpr std::uint64_t kMaxQuadNodes = 1u << 26; // as many as the largest --guide-memory holds

std::uint64_t fnv1a(std::span<const std::uint8_t> bytes) {
    std::uint64_t hash = 0xcbf29ce484222325;
    for (const std::uint8_t byte : bytes)
        hash = (hash ^ byte) * 0x100000001b3;
    return hash;
}

class Writer {
  public:
    void put(std::unsigned_integral auto value) {
        for (std::size_t i = 0; i < sizeof value; ++i)
            bytes.push_back(std::uint8_t(std::uint64_t(value) >> (8 * i)));
    }
    void put(double value) { put(std::bit_cast<std::uint64_t>(value)); }
    void put(float value) { put(std::bit_cast<std::uint32_t>(value)); }
    void put(const std::string& text) {
        count(text.size());
        bytes.insert(bytes.end(), text.begin(), text.end());
    }
    void count(std::size_t n) { put(std::uint64_t(n)); }

    Bytes bytes;
};

// Everything that is wrong with a file's contents.
struct Malformed {
    std::string what;
};

class Reader {
  public:
    explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    template <std::unsigned_integral T> T get() {
        T value = 0;
        const auto part = take(sizeof(T));
        for (std::size_t i = 0; i < sizeof(T); ++i)
            value = T(value | T(part[i]) << (8 * i));
        return value;
    }
    double real() { return std::bit_cast<double>(get<std::uint64_t>()); }
    float single() { return std::bit_cast<float>(get<std::uint32_t>()); }
    // A number that a figure can be: finite and not negative.
    double figure(const char* what) {
        const double value = real();
        if (!std::isfinite(value) || value < 0)
            throw Malformed{std::string(what) + " is negative or not finite"};
        return value;
    }
    // How many things of at least `bytes` each follow: never more than the rest of the file can hold.
    std::size_t count(std::size_t bytes) {
        const auto n = get<std::uint64_t>();
        if (n > bytes_.size() / bytes)
            throw Malformed{"it announces more than it holds"};
        return std::size_t(n);
    }
    std::string text() {
        const auto part = take(count(1));
        return {part.begin(), part.end()};
    }
    void end() const {
        if (!bytes_.empty())
            throw Malformed{"it holds more than it announces"};
    }

  private:
    std::span<const std::uint8_t> take(std::size_t n) {
        if (n > bytes_.size())
            throw Malformed{"it announces more than it holds"};
        const auto part = bytes_.first(n);
        bytes_ = bytes_.subspan(n);
        return part;
    }
    std::span<const std::uint8_t> bytes_;
};

void put(Writer& out, const std::map<Sampling, SamplingFigures>& figures) {
    out.count(figures.size());
    for (const auto& [kind, f] : figures) {
        out.put(std::uint32_t(kind));
        out.put(f.variance);
        out.put(f.rays);
        out.put(f.passes);
    }
}

std::map<Sampling, SamplingFigures> getFigures(Reader& in) {
    std::map<Sampling, SamplingFigures> figures;
    for (std::size_t n = in.count(4 + 2 * 8 + 4); n-- > 0;) {
        const auto kind = in.get<std::uint32_t>();
        if (kind >= std::uint32_t(Sampling::Auto) || figures.contains(Sampling(kind)))
            throw Malformed{"a sampling kind is unknown or named twice"};
        SamplingFigures& f = figures[Sampling(kind)];
        f.variance = in.figure("a variance");
        f.rays = in.figure("a number of rays");
        f.passes = in.get<std::uint32_t>();
    }
    return figures;
}

void put(Writer& out, const GuideRecord& record) {
    out.put(record.geometry);
    out.count(record.parameters.size());
    for (const std::string& name : record.parameters)
        out.put(name);
    put(out, record.figures);
    put(out, record.rouletteFigures);
    put(out, record.imageFigures);
    out.put(record.reference);
}

GuideRecord getRecord(Reader& in) {
    GuideRecord record;
    record.geometry = in.get<std::uint64_t>();
    record.parameters.resize(in.count(8));
    for (std::string& name : record.parameters)
        name = in.text();
    record.figures = getFigures(in);
    record.rouletteFigures = getFigures(in);
    record.imageFigures = getFigures(in);
    record.reference = in.figure("the reference of the roulette");
    return record;
}

void put(Writer& out, const SdTreeConfig& config) {
    out.put(config.cellRecords);
    out.put(config.directionShare);
    out.put(config.forgetting);
    out.put(config.maxQuadDepth);
    out.put(config.maxSpatialDepth);
    out.put(config.maxNodes);
}

SdTreeConfig getConfig(Reader& in) {
    SdTreeConfig config;
    config.cellRecords = in.get<std::uint32_t>();
    config.directionShare = in.figure("the share of a quadrant that splits");
    config.forgetting = in.figure("the forgetting factor");
    config.maxQuadDepth = in.get<std::uint32_t>();
    config.maxSpatialDepth = in.get<std::uint32_t>();
    config.maxNodes = in.get<std::uint64_t>();
    if (config.forgetting > 1 || config.maxQuadDepth < 1 || config.maxQuadDepth > gpu::kMaxQuadDepth ||
        config.maxSpatialDepth > gpu::kMaxSpatialDepth || config.maxNodes < 1 || config.maxNodes > kMaxQuadNodes)
        throw Malformed{"its settings are out of range"};
    return config;
}

void put(Writer& out, const GuideCell& cell) {
    out.put(cell.records);
    out.put(cell.reflected);
    out.put(cell.derivative);
    out.count(cell.nodes.size());
    for (const QuadNode& node : cell.nodes) {
        for (const GuideMass& m : node.mass) {
            out.put(m.primal);
            out.put(m.plus);
            out.put(m.minus);
        }
        for (const std::uint32_t child : node.child)
            out.put(child);
    }
}
constexpr std::size_t kQuadNodeBytes = 4 * (3 * 8 + 4), kCellBytes = 3 * 8 + 8 + kQuadNodeBytes; // with one node

GuideCell getCell(Reader& in) {
    GuideCell cell;
    cell.records = in.real();
    cell.reflected = in.real();
    cell.derivative = in.real();
    cell.nodes.resize(in.count(kQuadNodeBytes));
    for (QuadNode& node : cell.nodes) {
        for (GuideMass& m : node.mass) {
            m.primal = in.real();
            m.plus = in.real();
            m.minus = in.real();
        }
        for (std::uint32_t& child : node.child)
            child = in.get<std::uint32_t>();
    }
    return cell;
}

} // namespace

// Reaches into the tree.
class GuideFile {
  public:
    static void put(Writer& out, const SdTree& tree) {
        for (const glm::vec3& corner : {tree.lower_, tree.upper_})
            for (int axis = 0; axis < 3; ++axis)
                out.put(corner[axis]);
        cmpg::put(out, tree.config_);
        out.put(tree.updates_);
        out.count(tree.spatial_.size());
        for (const SpatialNode& node : tree.spatial_) {
            out.put(node.child);
            out.put(node.cell);
        }
        out.count(tree.cells_.size());
        for (const GuideCell& cell : tree.cells_)
            cmpg::put(out, cell);
    }

    static SdTree get(Reader& in) {
        SdTreeConfig least;
        least.maxNodes = 1;
        SdTree tree({}, {}, least);
        for (glm::vec3* corner : {&tree.lower_, &tree.upper_})
            for (int axis = 0; axis < 3; ++axis)
                (*corner)[axis] = in.single();
        tree.config_ = getConfig(in);
        tree.updates_ = in.get<std::uint32_t>();
        tree.spatial_.resize(in.count(2 * 4));
        for (SpatialNode& node : tree.spatial_) {
            node.child = in.get<std::uint32_t>();
            node.cell = in.get<std::uint32_t>();
        }
        tree.cells_.resize(in.count(kCellBytes));
        for (GuideCell& cell : tree.cells_)
            cell = getCell(in);
        if (const std::string wrong = tree.validate(); !wrong.empty())
            throw Malformed{wrong};
        return tree;
    }
};

void saveGuide(const std::filesystem::path& file, const SdTree& tree, const GuideRecord& record) {
    Writer content;
    put(content, record);
    GuideFile::put(content, tree);

    Writer out;
    out.put(kMagic);
    out.put(kVersion);
    out.count(content.bytes.size());
    out.bytes.insert(out.bytes.end(), content.bytes.begin(), content.bytes.end());
    out.put(fnv1a(out.bytes));
    writeFile(file, out.bytes);
}

LoadedGuide loadGuide(const std::filesystem::path& file) {
    const Bytes bytes = readFile(file);
    const auto refuse = [&](const std::string& what, const std::string& cause, const std::string& remedy = "save the guide anew") {
        return Error(ExitCode::Input, file.string() + " " + what, cause, remedy);
    };
    const std::span<const std::uint8_t> all = bytes;
    if (all.size() < 8 || Reader(all).get<std::uint64_t>() != kMagic)
        throw refuse("is no guide", "it is another kind of file, or empty", "name a file that --save-guide wrote");
    if (all.size() < kHeaderBytes + kChecksumBytes)
        throw refuse("is truncated", "writing or copying it was cut short");
    Reader header(all.subspan(8));
    if (const auto version = header.get<std::uint32_t>(); version != kVersion)
        throw refuse("is a guide of version " + std::to_string(version) + ", not " + std::to_string(kVersion),
                     "another version of this program wrote it");
    const auto size = header.get<std::uint64_t>();
    const std::size_t present = all.size() - kHeaderBytes - kChecksumBytes;
    if (size != present)
        throw refuse(size > present ? "is truncated" : "has bytes after its end", "writing or copying it went wrong");
    if (Reader(all.last(kChecksumBytes)).get<std::uint64_t>() != fnv1a(all.first(all.size() - kChecksumBytes)))
        throw refuse("is damaged: its checksum is wrong", "it was changed after it was written");
    try {
        Reader in(all.subspan(kHeaderBytes, present));
        GuideRecord record = getRecord(in);
        SdTree tree = GuideFile::get(in);
        in.end();
        return {std::move(tree), std::move(record)};
    } catch (const Malformed& malformed) {
        throw refuse("is no valid guide: " + malformed.what, "it was made by something else");
    }
}

} // namespace cmpg
