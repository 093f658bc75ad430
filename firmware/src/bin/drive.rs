//! `drive`: the observer in a drive's control interrupt.
//!
//! It only listens, unless it was built with an output stage and is told to use it. The control
//! interrupt owns the board and the session; the idle task moves frames. It links only if no panic
//! can be reached: the panic handler calls a function that does not exist.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[rtic::app(device = stm32_metapac, peripherals = false)]
mod app {
    #![allow(missing_docs)]

    use firmware::link::{self, Commands, Link, Messages};
    use firmware::session::Session;
    use firmware::stm32::{Board, RTT, parameter_page};

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        board: Board,
        session: &'static mut Session,
        link: Link,
    }

    static COMMANDS: Commands = link::commands();
    static MESSAGES: Messages = link::messages();

    #[init(local = [place: Session = Session::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let init::LocalResources { place: session, .. } = cx.local;
        RTT.publish();
        match session.start(parameter_page()) {
            Ok(None) => {
                defmt::info!("parameters {=u32:08x} accepted", session.hello().parameters_crc)
            }
            Ok(Some(why)) => defmt::error!(
                "parameters refused, reason {=u8}: listening with the defaults",
                why.code()
            ),
            Err(why) => defmt::error!("defaults refused, reason {=u8}", why.code()),
        }
        let board = Board::start(&session.sensing());
        (Shared {}, Local { board, session, link: Link::default() })
    }

    #[task(binds = TIM1_CC, priority = 2, local = [board, session])]
    fn control(cx: control::Context) {
        let control::LocalResources { board, session, .. } = cx.local;
        while let Some(command) = COMMANDS.dequeue() {
            session.command(command);
            board.command(command);
        }
        let sample = board.sample();
        let flags = board.drive();
        session.tick(sample, 0, flags, &MESSAGES);
    }

    #[idle(local = [link])]
    fn idle(cx: idle::Context) -> ! {
        let link = cx.local.link;
        loop {
            link.send(&MESSAGES, |frame| RTT.telemetry().write(frame));
            while let Some(byte) = RTT.commands().read() {
                #[cfg(feature = "planted-panic")]
                {
                    let table = [1_u8, 2, 3];
                    core::hint::black_box(table[usize::from(byte)]);
                }
                link.receive(byte, &COMMANDS);
            }
        }
    }
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // Whoever meets this name in a linker's message: some code can panic. Its place is in the same
    // message.
    #[allow(unsafe_code)]
    unsafe extern "C" {
        safe fn a_panic_can_be_reached() -> !;
    }
    a_panic_can_be_reached()
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("drive runs on a board: build it for thumbv7em-none-eabihf");
}
