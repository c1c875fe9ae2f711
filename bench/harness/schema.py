"""The database of results: its tables, and the view that puts them together."""

APPLICATION_ID = 0x41445242
FORMAT = 2
"""Kept in the file as ``user_version``: files of another format are refused, not guessed at."""

ROW_COLUMNS = (
    "suite",
    "field",
    "iteration",
    "zones",
    "method",
    "seed",
    "outcome",
    "message",
    "violations",
    "status",
    "visits",
    "refuellings",
    "objective",
    "delta_v_m_s",
    "duration_used_s",
    "planning_s",
    "runtime_s",
    "check_s",
    "build_s",
    "upper_bound",
    "sha256",
    "sequence",
    "environment",
    "run",
    "finished",
    "planning_cpu_s",
    "build_cpu_s",
)
BOUND_COLUMNS = (
    "suite",
    "field",
    "iteration",
    "zones",
    "method",
    "limit_s",
    "upper_bound",
    "status",
    "planning_s",
    "message",
    "environment",
    "run",
    "finished",
)

SCHEMA = """
CREATE TABLE run (
    id INTEGER PRIMARY KEY,
    command TEXT NOT NULL,
    methods TEXT NOT NULL,             -- in the order typed, separated by spaces
    host TEXT NOT NULL,
    pid INTEGER NOT NULL,
    workers INTEGER,
    begun TEXT NOT NULL,               -- UTC
    alive REAL NOT NULL,               -- last sign of life, seconds since 1970
    ended TEXT,
    wall_s REAL,                       -- from the first task handed out to the last one back
    spent TEXT                         -- JSON: seconds of all workers by what they did
);
CREATE TABLE environment (
    id INTEGER PRIMARY KEY,
    host TEXT NOT NULL, processor TEXT NOT NULL, cores INTEGER NOT NULL,
    python TEXT NOT NULL, versions TEXT NOT NULL,
    UNIQUE (host, processor, cores, python, versions)
);
CREATE TABLE row (
    suite TEXT NOT NULL,
    field INTEGER NOT NULL,
    iteration INTEGER NOT NULL,
    zones INTEGER NOT NULL,
    method TEXT NOT NULL,
    seed INTEGER NOT NULL,
    outcome TEXT NOT NULL CHECK (outcome IN ('legal', 'illegal', 'raised', 'died')),
    message TEXT,                      -- what was wrong
    violations INTEGER,                -- that check found
    status TEXT,
    visits INTEGER,
    refuellings INTEGER,
    objective REAL,
    delta_v_m_s REAL,
    duration_used_s REAL,
    planning_s REAL,                   -- the whole call of solve, from a ready timetable
    runtime_s REAL,                    -- what the planner states
    check_s REAL,
    build_s REAL,                      -- of the timetable, shared by the methods of a trial
    upper_bound REAL,                  -- proven by the planner itself
    sha256 TEXT,                       -- of the instance file
    sequence TEXT,                     -- bodies in order, 0 is the station; / between chasers
    environment INTEGER NOT NULL REFERENCES environment,
    run INTEGER NOT NULL REFERENCES run,
    finished TEXT NOT NULL,            -- UTC
    planning_cpu_s REAL,               -- of processors, all threads together
    build_cpu_s REAL,
    PRIMARY KEY (suite, field, iteration, zones, method, seed)
) WITHOUT ROWID;
CREATE TABLE bound (
    suite TEXT NOT NULL,
    field INTEGER NOT NULL,
    iteration INTEGER NOT NULL,
    zones INTEGER NOT NULL,
    method TEXT NOT NULL,
    limit_s REAL NOT NULL,
    upper_bound REAL,
    status TEXT,
    planning_s REAL,
    message TEXT,
    environment INTEGER NOT NULL REFERENCES environment,
    run INTEGER NOT NULL REFERENCES run,
    finished TEXT NOT NULL,
    PRIMARY KEY (suite, field, iteration, zones, method, limit_s)
) WITHOUT ROWID;
CREATE TABLE claim (
    suite TEXT NOT NULL,
    field INTEGER NOT NULL,
    iteration INTEGER NOT NULL,
    zones INTEGER NOT NULL,
    run INTEGER NOT NULL REFERENCES run,
    PRIMARY KEY (suite, field, iteration, zones)
) WITHOUT ROWID;
-- The least bound of a trial, whoever proved it: a bound, or a planner with a legal plan.
CREATE VIEW proven AS
    SELECT suite, field, iteration, zones, min(upper_bound) AS bound FROM (
        SELECT suite, field, iteration, zones, upper_bound FROM bound
        UNION ALL
        SELECT suite, field, iteration, zones, upper_bound FROM row WHERE outcome = 'legal'
    ) WHERE upper_bound IS NOT NULL GROUP BY suite, field, iteration, zones;
CREATE VIEW result AS
    SELECT row.suite, row.field, row.iteration, row.zones, row.method, row.seed, outcome, message,
        violations, status, visits, refuellings, objective, delta_v_m_s, duration_used_s,
        planning_s, runtime_s, check_s, build_s, planning_cpu_s, build_cpu_s, bound,
        CASE WHEN outcome <> 'legal' THEN NULL WHEN bound > 0 THEN (bound - objective) / bound
            WHEN bound = 0 THEN 0.0 END AS gap,
        sha256, sequence, host, processor, cores, python, versions, run, finished
    FROM row JOIN environment ON environment.id = row.environment
    LEFT JOIN proven USING (suite, field, iteration, zones);
"""

NEWER = (
    "ALTER TABLE row ADD COLUMN planning_cpu_s REAL",
    "ALTER TABLE row ADD COLUMN build_cpu_s REAL",
    "DROP VIEW result",
    SCHEMA[SCHEMA.index("CREATE VIEW result") :],
)
"""Statements that convert a file of format 1 to format 2, whose rows record processor time."""
