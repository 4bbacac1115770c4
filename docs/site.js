// Subscripts and exponents of symbols in the text of the pages about equations: u_k, u_{k-1}, x^n.
(function () {
    if (!/(equations(-immersed)?|numerics)\.html$/.test(location.pathname)) return;
    const part = /(?<=[\p{L}\p{M}\p{N}\p{S})\]'*⟩|])([_^])(?:\{([^}]*)\}|(-?[\p{Ll}\p{Lu}0-9]+[*+−]?))/gu;
    const texts = [];
    const walk = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
    while (walk.nextNode()) {
        if (!walk.currentNode.parentElement.closest("code, .katex")) texts.push(walk.currentNode);
    }
    for (const node of texts) {
        const found = [...node.data.matchAll(part)];
        let rest = node;
        let begin = 0;
        for (const match of found) {
            const small = document.createElement(match[1] === "_" ? "sub" : "sup");
            small.textContent = match[2] ?? match[3];
            rest = rest.splitText(match.index - begin);
            rest.parentNode.insertBefore(small, rest);
            rest.data = rest.data.slice(match[0].length);
            begin = match.index + match[0].length;
        }
    }
})();
