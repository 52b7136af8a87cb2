// Guides on disk. Little endian: magic, version, bytes of content, content, FNV-1a of everything before.
#include "guiding/guide_file.h"

#include "base/byte_stream.h"
#include "base/error.h"
#include "base/hash.h"
#include "scene/file_io.h"
#include "shared/guide.h"

#include <algorithm>

namespace cmpg {
namespace {

constexpr std::uint64_t kMagic = 0x0a45444955475643; // "CVGUIDE\n"
constexpr std::uint32_t kVersion = 2;
constexpr std::size_t kHeaderBytes = 8 + 4 + 8, kChecksumBytes = 8;
constexpr std::uint64_t kMaxQuadNodes = 1u << 26; // as many as the largest --guide-memory holds

void put(ByteWriter& out, const std::map<Sampling, SamplingFigures>& figures) {
    out.count(figures.size());
    for (const auto& [kind, f] : figures) {
        out.put(std::uint32_t(kind));
        putFigures(out, f);
    }
}

std::map<Sampling, SamplingFigures> getKinds(ByteReader& in) {
    std::map<Sampling, SamplingFigures> figures;
    for (std::size_t n = in.count(4 + 2 * 8 + 4); n-- > 0;) {
        const auto kind = in.get<std::uint32_t>();
        if (kind >= std::uint32_t(Sampling::Auto) || figures.contains(Sampling(kind)))
            throw Malformed{"a sampling kind is unknown or named twice"};
        figures[Sampling(kind)] = getFigures(in);
    }
    return figures;
}

void put(ByteWriter& out, const GuideContext& context) {
    out.put(context.geometry);
    out.count(context.parameters.size());
    for (const std::string& name : context.parameters)
        out.put(name);
    put(out, context.figures);
    put(out, context.rouletteFigures);
    put(out, context.imageFigures);
    out.put(context.reference);
}

GuideContext getContext(ByteReader& in) {
    GuideContext context;
    context.geometry = in.get<std::uint64_t>();
    context.parameters.resize(in.count(8));
    for (std::string& name : context.parameters)
        name = in.text();
    context.figures = getKinds(in);
    context.rouletteFigures = getKinds(in);
    context.imageFigures = getKinds(in);
    context.reference = in.figure("the reference of the roulette");
    return context;
}

void put(ByteWriter& out, const SdTreeConfig& config) {
    out.put(config.cellRecords);
    out.put(config.directionShare);
    out.put(config.forgetting);
    out.put(config.maxQuadDepth);
    out.put(config.maxSpatialDepth);
    out.put(config.maxNodes);
}

SdTreeConfig getConfig(ByteReader& in) {
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

void put(ByteWriter& out, const GuideCell& cell) {
    out.put(cell.records);
    out.put(cell.faded);
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
constexpr std::size_t kQuadNodeBytes = 4 * (3 * 8 + 4), kCellBytes = 4 * 8 + 8 + kQuadNodeBytes; // with one node

GuideCell getCell(ByteReader& in) {
    GuideCell cell;
    cell.records = in.real();
    cell.faded = in.real();
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
    static void put(ByteWriter& out, const SdTree& tree) {
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

    static SdTree get(ByteReader& in) {
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

void putTree(ByteWriter& out, const SdTree& tree) { GuideFile::put(out, tree); }
SdTree getTree(ByteReader& in) { return GuideFile::get(in); }

void putFigures(ByteWriter& out, const SamplingFigures& figures) {
    out.put(figures.variance);
    out.put(figures.rays);
    out.put(figures.passes);
}

SamplingFigures getFigures(ByteReader& in) {
    SamplingFigures figures;
    figures.variance = in.figure("a variance");
    figures.rays = in.figure("a number of rays");
    figures.passes = in.get<std::uint32_t>();
    return figures;
}

void saveGuide(const std::filesystem::path& file, const SdTree& tree, const GuideContext& context) {
    ByteWriter content;
    put(content, context);
    GuideFile::put(content, tree);

    ByteWriter out;
    out.put(kMagic);
    out.put(kVersion);
    out.count(content.bytes.size());
    out.bytes.insert(out.bytes.end(), content.bytes.begin(), content.bytes.end());
    out.put(hashOf(std::as_bytes(std::span(out.bytes))));
    writeFile(file, out.bytes);
}

LoadedGuide loadGuide(const std::filesystem::path& file) {
    const Bytes bytes = readFile(file);
    const auto refuse = [&](const std::string& what, const std::string& cause, const std::string& remedy = "save the guide anew") {
        return Error(ErrorKind::Input, file.string() + " " + what, cause, remedy);
    };
    const std::span<const std::uint8_t> all = bytes;
    if (all.size() < 8 || ByteReader(all).get<std::uint64_t>() != kMagic)
        throw refuse("is no guide", "it is another kind of file, or empty", "name a file that a run saved its guide to");
    if (all.size() < kHeaderBytes + kChecksumBytes)
        throw refuse("is truncated", "writing or copying it was cut short");
    ByteReader header(all.subspan(8));
    if (const auto version = header.get<std::uint32_t>(); version != kVersion)
        throw refuse("is a guide of version " + std::to_string(version) + ", not " + std::to_string(kVersion),
                     "another version of this program wrote it");
    const auto size = header.get<std::uint64_t>();
    const std::size_t present = all.size() - kHeaderBytes - kChecksumBytes;
    if (size != present)
        throw refuse(size > present ? "is truncated" : "has bytes after its end", "writing or copying it went wrong");
    if (ByteReader(all.last(kChecksumBytes)).get<std::uint64_t>() != hashOf(std::as_bytes(all.first(all.size() - kChecksumBytes))))
        throw refuse("is damaged: its checksum is wrong", "it was changed after it was written");
    try {
        ByteReader in(all.subspan(kHeaderBytes, present));
        GuideContext context = getContext(in);
        SdTree tree = GuideFile::get(in);
        in.end();
        return {std::move(tree), std::move(context)};
    } catch (const Malformed& malformed) {
        throw refuse("is no valid guide: " + malformed.what, "it was made by something else");
    }
}

} // namespace cmpg
