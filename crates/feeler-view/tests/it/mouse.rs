//! The page in a browser: turned and zoomed by its mouse, a cube looks as wide as perspective says.
//!
//! Chromium is driven through its DevTools protocol over a pipe (file descriptors 3 and 4). Skipped aloud where there is none, or none that draws
//! WebGL 2; `FEELER_CHROMIUM` names another.

use feeler::brep::{Brep, BrepBuilder};
use feeler_corpus::Model;
use feeler_view::{Fineness, View};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// How long a browser may take for an answer; a loaded machine needs some seconds.
const PATIENCE: Duration = Duration::from_secs(120);
/// Of the page, `view.js`.
const VIEW_ANGLE: f64 = 28.0;
const TURN: f64 = 0.008;
const ZOOM: f64 = 0.003;
const ROOM: f64 = 1.08;
const FIRST: [f64; 3] = [0.5, -0.7, 0.6];

struct Browser {
    child: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    session: Option<String>,
    asked: u64,
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Its other processes end with it.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Browser {
    /// `None` where there is no such program.
    fn start() -> Option<Self> {
        let names = ["chromium", "chromium-browser", "google-chrome"].map(str::to_owned);
        let given = std::env::var("FEELER_CHROMIUM").ok().into_iter();
        let runs = |name: &String| {
            let asked = Command::new(name).arg("--version").output();
            asked.is_ok_and(|o| o.status.success())
        };
        let program = given.chain(names).find(runs)?;
        let profile = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("chromium");
        let script = format!(
            "exec '{program}' --headless=new --no-sandbox --no-first-run --hide-scrollbars --use-angle=swiftshader --enable-unsafe-swiftshader \
             --remote-debugging-pipe --user-data-dir='{}' about:blank 3<&0 4>&1 </dev/null >/dev/null",
            profile.display()
        );
        let mut child = Command::new("sh")
            .args(["-c", &script])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let (to, out) = (child.stdin.take()?, child.stdout.take()?);
        let (send, from) = channel();
        std::thread::spawn(move || {
            let mut out = BufReader::new(out);
            loop {
                let mut message = Vec::new();
                if !matches!(out.read_until(0, &mut message), Ok(1..)) {
                    return;
                }
                message.pop();
                let Ok(value) = serde_json::from_slice(&message) else {
                    return;
                };
                if send.send(value).is_err() {
                    return;
                }
            }
        });
        Some(Self {
            child,
            to,
            from,
            session: None,
            asked: 0,
        })
    }

    fn ask(&mut self, method: &str, params: &Value) -> Value {
        self.asked += 1;
        let mut message = json!({"id": self.asked, "method": method, "params": params});
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        let mut text = message.to_string().into_bytes();
        text.push(0);
        self.to.write_all(&text).unwrap();
        loop {
            let said = self.from.recv_timeout(PATIENCE).unwrap();
            if said["id"] == json!(self.asked) {
                assert!(said["error"].is_null(), "{method}: {said}");
                return said["result"].clone();
            }
        }
    }

    /// The value of an expression, awaited.
    fn value(&mut self, expression: &str) -> Value {
        let asked = json!({"expression": expression, "awaitPromise": true, "returnByValue": true});
        let answer = self.ask("Runtime.evaluate", &asked);
        assert!(answer["exceptionDetails"].is_null(), "{answer}");
        answer["result"]["value"].clone()
    }

    fn mouse(&mut self, kind: &str, at: [f64; 2], more: &Value) {
        let mut event = json!({"type": kind, "x": at[0], "y": at[1]});
        for (key, value) in more.as_object().unwrap() {
            event[key] = value.clone();
        }
        self.ask("Input.dispatchMouseEvent", &event);
    }

    fn drag(&mut self, from: [f64; 2], by: [f64; 2]) {
        let held = json!({"button": "left", "buttons": 1, "clickCount": 1});
        let to = [from[0] + by[0], from[1] + by[1]];
        self.mouse("mousePressed", from, &held);
        self.mouse("mouseMoved", to, &held);
        let free = json!({"button": "left", "buttons": 0, "clickCount": 1});
        self.mouse("mouseReleased", to, &free);
    }

    /// Width and height of what is drawn, in pixels: all that is not as the corner is.
    fn drawn(&mut self) -> [f64; 2] {
        let seen = self.value(
            "new Promise((done) => {
              window.dispatchEvent(new Event('resize'));
              requestAnimationFrame(() => {
                const from = document.getElementById('view');
                const to = document.createElement('canvas');
                [to.width, to.height] = [from.width, from.height];
                const on = to.getContext('2d');
                on.drawImage(from, 0, 0);
                const { data } = on.getImageData(0, 0, to.width, to.height);
                let box = [1e9, 1e9, -1, -1];
                for (let y = 0; y < to.height; y++) for (let x = 0; x < to.width; x++) {
                  const i = 4 * (y * to.width + x);
                  let off = 0;
                  for (let c = 0; c < 4; c++) off = Math.max(off, Math.abs(data[i + c] - data[c]));
                  if (off > 16) box = [Math.min(box[0], x), Math.min(box[1], y), Math.max(box[2], x), Math.max(box[3], y)];
                }
                done([box[2] - box[0] + 1, box[3] - box[1] + 1]);
              });
            })",
        );
        [0, 1].map(|k| seen[k].as_f64().unwrap())
    }
}

/// About the origin.
fn cube(half: f64) -> Brep {
    let mut b = BrepBuilder::new();
    let sign = |i: usize, c: usize| if i >> c & 1 == 0 { -half } else { half };
    let corners: Vec<usize> = (0..8)
        .map(|i| b.vertex([sign(i, 0), sign(i, 1), sign(i, 2)]))
        .collect();
    for face in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        b.planar_face(&face.map(|i| corners[i])).unwrap();
    }
    b.build().unwrap()
}

#[test]
fn the_mouse_turns_and_zooms() {
    let Some(mut browser) = Browser::start() else {
        eprintln!("SKIPPED: no chromium; FEELER_CHROMIUM names one");
        return;
    };
    let half = 1.0;
    let model = Model {
        path: PathBuf::from("cube"),
        breps: vec![cube(half)],
    };
    let view = View::new("cube", &model, &Fineness::default()).unwrap();
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("mouse.html");
    std::fs::write(&path, view.page()).unwrap();

    let target = browser.ask("Target.createTarget", &json!({"url": "about:blank"}));
    let asked = json!({"targetId": target["targetId"], "flatten": true});
    let attached = browser.ask("Target.attachToTarget", &asked);
    browser.session = attached["sessionId"].as_str().map(str::to_owned);
    let size = json!({"width": 1200, "height": 800, "deviceScaleFactor": 1, "mobile": false});
    browser.ask("Emulation.setDeviceMetricsOverride", &size);
    let url = format!("file://{}", path.display());
    browser.ask("Page.navigate", &json!({"url": url}));
    browser.value(
        "new Promise((done) => { const look = () => document.readyState === 'complete' && document.getElementById('view') \
         ? done(true) : setTimeout(look, 20); look(); })",
    );
    let trouble = browser.value("document.getElementById('trouble').textContent");
    if trouble != json!("") {
        eprintln!("SKIPPED: this chromium draws no WebGL 2: {trouble}");
        return;
    }
    let side = |name: &str| format!("document.getElementById('view').client{name}");
    let [width, height] = ["Width", "Height"].map(|n| browser.value(&side(n)).as_f64().unwrap());
    let middle = [width / 2.0, height / 2.0];

    // As the page has it: the whole ball around the cube in sight. (The panel is beside it: the picture is the narrower way.)
    let across = (VIEW_ANGLE / 2.0).to_radians().tan();
    let narrow = across.atan().min((across * width / height).atan());
    let radius = half * 3f64.sqrt();
    let distance = ROOM * radius / narrow.sin();
    let pixels = height / 2.0 / across;
    let first = browser.drawn();

    // Straight from above, the sides along the picture's: the pitch stops at the top, and the yaw goes to a quarter turn.
    let yaw = FIRST[1].atan2(FIRST[0]) + std::f64::consts::FRAC_PI_2;
    let aside = (yaw / TURN).round();
    browser.drag(middle, [aside, 300.0]);
    let turned = browser.drawn();
    // The top is nearer by half a side, and turned by the part of a pixel that a mouse does not go.
    let left = (yaw - aside * TURN).abs();
    let wide = |distance: f64| 2.0 * half * (1.0 + left) / (distance - half) * pixels;
    // Edges are drawn some pixels wide, half of it outside.
    let near = |seen: f64, expected: f64| (seen - expected).abs() < 4.0;
    for seen in turned {
        assert!(near(seen, wide(distance)), "{turned:?} {}", wide(distance));
    }
    assert!(!near(first[0], turned[0]), "{first:?} {turned:?}");

    // Away by the wheel, and nearer again.
    let wheel = |browser: &mut Browser, by: f64| {
        browser.mouse("mouseWheel", middle, &json!({"deltaX": 0, "deltaY": by}));
    };
    wheel(&mut browser, 50.0);
    let away = browser.drawn();
    let farther = wide(distance * (50.0 * ZOOM).exp());
    assert!(
        near(away[0], farther) && near(away[1], farther),
        "{away:?} {farther}"
    );
    assert!(!near(away[0], turned[0]));
    wheel(&mut browser, -50.0);
    let back = browser.drawn();
    assert!(
        near(back[0], turned[0]) && near(back[1], turned[1]),
        "{back:?} {turned:?}"
    );
    // Half a turn on it looks the same, an eighth of a turn wider by the diagonal.
    browser.drag(middle, [(std::f64::consts::FRAC_PI_4 / TURN).round(), 0.0]);
    let eighth = browser.drawn();
    let diagonal = wide(distance) * 2f64.sqrt();
    assert!((eighth[0] - diagonal).abs() < 8.0, "{eighth:?} {diagonal}");
}
