; Says sentences with Festival and prints the phones of each token. mien appends (speak-sentence TEXT WAVE-FILE) lines.

(define (print-phones syllable)
  (mapcar
   (lambda (segment)
     (format t "phone %s %f %f\n" (item.name segment) (item.feat segment "segment_start") (item.feat segment "end")))
   (item.daughters syllable)))

(define (print-token token)
  (format t "token\n")
  (mapcar
   (lambda (word) (mapcar print-phones (item.daughters (item.relation word 'SylStructure))))
   (item.daughters token)))

(define (speak-sentence text wave)
  (let ((utterance (utt.synth (eval (list 'Utterance 'Text text)))))
    (utt.save.wave utterance wave 'riff)
    (format t "sentence\n")
    (let ((token (utt.relation.first utterance 'Token)))
      (while token
        (print-token token)
        (set! token (item.next token))))))
