/// What the study runs on, for the report: processor and threads.
pub fn machine() -> String {
    let threads = rayon::current_num_threads();
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find_map(|l| l.strip_prefix("model name")?.split_once(':'))?;
        Some(line.1.trim().to_string())
    });
    let model = model.unwrap_or_else(|| format!("a processor of the kind {}", std::env::consts::ARCH));
    format!("{model}, {threads} {}", if threads == 1 { "thread" } else { "threads" })
}
